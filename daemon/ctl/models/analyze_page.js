"use strict";
// Draws the stacked contours as a picture that can be rotated (thesis, figures 4.1 to 4.7): lines in WebGL 2, or on a
// 2-D canvas without WebGL. Marks (box, islands, suction cups, resin traps, contacts of supports) are drawn on a second
// canvas above it.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const places = [...data.islands, ...data.voids];
  const byId = (id) => document.getElementById(id);
  const stage = byId("stage"), marks = byId("marks");
  if (data.layers.length === 0) {
    byId("note").textContent = "There is nothing to show.";
    return;
  }

  // --- the contours, from 16-bit words to millimetres around the middle of the picture

  // The picture's coordinates are those of the plate (mm) minus `middle`; they range from -reach to reach.
  const middle = [0, 0, data.top_mm / 2], reach = [0, 0, data.top_mm / 2];

  function decode() {
    // The models' loops, then the supports'.
    const texts = [atob(data.loops), atob(data.support_loops)], size = texts[0].length;
    const words = new DataView(new ArrayBuffer(size + texts[1].length));
    for (let i = 0; i < size; ++i) words.setUint8(i, texts[0].charCodeAt(i));
    for (let i = 0; i < texts[1].length; ++i) words.setUint8(size + i, texts[1].charCodeAt(i));
    const word = (i) => words.getUint16(2 * i, true);
    const loops = [], count = words.byteLength / 2;
    let points = 0;
    for (let i = 0; i < count; i += 3 + 2 * loops[loops.length - 1].count) {
      loops.push({layer: word(i), count: word(i + 1) + 65536 * word(i + 2), first: points, at: i + 3, support: 2 * i >= size});
      points += loops[loops.length - 1].count;
    }
    const ends = [[65535, 0], [65535, 0]];  // smallest and largest word along x and y
    for (const loop of loops) {
      for (let i = 0; i < 2 * loop.count; ++i) {
        const end = ends[i % 2], w = word(loop.at + i);
        end[0] = Math.min(end[0], w);
        end[1] = Math.max(end[1], w);
      }
    }
    const positions = new Float32Array(3 * points), scale = data.size_mm / 65535;
    ends.forEach(([low, high], axis) => {
      middle[axis] = data.min_mm[axis] + (low + high) / 2 * scale;
      reach[axis] = Math.max(high - low, 0) / 2 * scale;
    });
    for (const loop of loops) {
      for (let k = 0; k < loop.count; ++k) {
        const at = 3 * (loop.first + k);
        positions[at] = data.min_mm[0] + word(loop.at + 2 * k) * scale - middle[0];
        positions[at + 1] = data.min_mm[1] + word(loop.at + 2 * k + 1) * scale - middle[1];
        positions[at + 2] = data.heights_mm[loop.layer] - middle[2];
      }
    }
    return {loops, positions, points};
  }
  const {loops, positions, points} = decode();
  const radius = Math.max(Math.hypot(...reach), 1e-6);

  // --- the view

  const views = {
    corner: {yaw: -0.6, pitch: 0.42}, front: {yaw: 0, pitch: 0},
    side: {yaw: -Math.PI / 2, pitch: 0}, top: {yaw: 0, pitch: Math.PI / 2},
  };
  const view = {...views.corner, zoom: 1, shift: [0, 0], shown: data.layers.length, chosen: -1, supports: true};
  let wanted = false;
  const redraw = () => {
    if (wanted) return;
    wanted = true;
    requestAnimationFrame(() => { wanted = false; draw(); });
  };

  // Returns a matrix whose rows give a point's coordinates on the screen: right, up, away from the viewer (mm).
  function axes() {
    const cy = Math.cos(view.yaw), sy = Math.sin(view.yaw), cp = Math.cos(view.pitch), sp = Math.sin(view.pitch);
    return [[cy, -sy, 0], [sy * sp, cy * sp, cp], [sy * cp, cy * cp, -sp]];
  }
  const pixelsPerMm = () => 0.5 * Math.min(marks.width, marks.height * 1.15) / radius * view.zoom;
  function project(p) {
    const [right, up] = axes(), scale = pixelsPerMm();
    const along = (axis) => axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
    return [marks.width / 2 + view.shift[0] + along(right) * scale, marks.height / 2 + view.shift[1] - along(up) * scale];
  }

  // --- colours

  const ramp = [[70, 98, 215], [54, 170, 249], [26, 228, 182], [114, 254, 94], [200, 239, 52], [250, 186, 57],
    [246, 107, 25], [203, 42, 4]];
  function colorOf(part) {
    const at = Math.min(Math.max(part, 0), 1) * (ramp.length - 1), i = Math.min(Math.floor(at), ramp.length - 2);
    return ramp[i].map((from, k) => Math.round(from + (ramp[i + 1][k] - from) * (at - i)));
  }
  const supportColor = [168, 150, 196];
  const causeColors = {island: "#ff4d8d", overhang: "#ffd166", peel: "#5ad1ff"};
  const cssOf = (part) => `rgb(${colorOf(part).join(" ")})`;
  const figure = (value) => value === 0 ? "0" : Math.abs(value) >= 1000 ? value.toFixed(0) : value.toPrecision(3);

  // Returns the ends of the scale. The largest 1 % of values share its upper end: times that other processes disturbed.
  function rangeOf(values) {
    const sorted = [...values].sort((a, b) => a - b);
    const high = sorted[Math.floor((sorted.length - 1) * 0.99)];
    return {low: sorted[0], high, more: sorted[sorted.length - 1] > high};
  }
  let parts = [];  // position on the scale (0 to 1), by layer
  function chooseQuantity(index) {
    const quantity = data.quantities[index], range = rangeOf(quantity.values), span = range.high - range.low;
    parts = quantity.values.map((value) => span > 0 ? (value - range.low) / span : 0);
    byId("unit").textContent = quantity.name + (quantity.unit ? ", " + quantity.unit : "");
    byId("ramp").style.background = `linear-gradient(to top, ${ramp.map((_, i) => cssOf(i / (ramp.length - 1))).join(", ")})`;
    byId("ticks").replaceChildren(...[1, 0.75, 0.5, 0.25, 0].map((part) => {
      const tick = document.createElement("span");
      tick.textContent = (part === 1 && range.more ? "≥ " : "") + figure(range.low + part * span);
      return tick;
    }));
    painter.paint(parts);
    redraw();
  }

  // --- lines by WebGL 2

  const vertexShader = `#version 300 es
    in vec3 position; in vec3 color; uniform mat3 turn; uniform vec2 scale, shift; uniform float radius; out vec3 shade;
    void main() {
      vec3 p = turn * position;
      float depth = p.z / radius;
      gl_Position = vec4(p.xy * scale + shift, depth * 0.99, 1.0);
      shade = mix(color, vec3(0.063, 0.082, 0.106), clamp(0.32 * (depth + 0.6), 0.0, 0.6));
    }`;
  const fragmentShader = `#version 300 es
    precision mediump float; in vec3 shade; out vec4 result;
    void main() { result = vec4(shade, 1.0); }`;

  function glPainter() {
    const canvas = byId("contours"), gl = canvas.getContext("webgl2", {antialias: true, alpha: false, preserveDrawingBuffer: true});
    if (!gl) return null;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
    gl.useProgram(program);
    // Pairs of a point and the next point of its loop; loops are ordered by layer.
    const pairs = new Uint32Array(2 * points);
    const ends = [false, true].map(() => new Array(data.layers.length + 1).fill(0));  // of models, of supports
    const begins = [0, 2 * (loops.find((loop) => loop.support) || {first: points}).first];
    for (const loop of loops) {
      for (let k = 0; k < loop.count; ++k) {
        pairs[2 * (loop.first + k)] = loop.first + k;
        pairs[2 * (loop.first + k) + 1] = loop.first + (k + 1) % loop.count;
      }
      ends[Number(loop.support)][loop.layer + 1] = 2 * (loop.first + loop.count);
    }
    ends.forEach((each, kind) => {
      each[0] = begins[kind];
      for (let i = 1; i < each.length; ++i) each[i] = Math.max(each[i], each[i - 1]);
    });
    const attribute = (name, size, type, normalized) => {
      const place = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, normalized, 0, 0);
    };
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, positions, gl.STATIC_DRAW);
    attribute("position", 3, gl.FLOAT, false);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, pairs, gl.STATIC_DRAW);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    const place = (name) => gl.getUniformLocation(program, name);
    const turn = place("turn"), scale = place("scale"), shift = place("shift"), size = place("radius");
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.063, 0.082, 0.106, 1);
    return {
      canvas,
      paint(layerParts) {
        const colors = new Uint8Array(3 * points);
        for (const loop of loops) {
          const color = loop.support ? supportColor : colorOf(layerParts[loop.layer]);
          for (let k = 0; k < loop.count; ++k) colors.set(color, 3 * (loop.first + k));
        }
        gl.bufferData(gl.ARRAY_BUFFER, colors, gl.STATIC_DRAW);
        attribute("color", 3, gl.UNSIGNED_BYTE, true);
      },
      draw() {
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        const [a, b, c] = axes(), mm = 2 * pixelsPerMm();
        gl.uniformMatrix3fv(turn, false, [a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]]);
        gl.uniform2f(scale, mm / canvas.width, mm / canvas.height);
        gl.uniform2f(shift, 2 * view.shift[0] / canvas.width, -2 * view.shift[1] / canvas.height);
        gl.uniform1f(size, radius);
        for (const kind of view.supports ? [0, 1] : [0]) {
          gl.drawElements(gl.LINES, ends[kind][view.shown] - begins[kind], gl.UNSIGNED_INT, 4 * begins[kind]);
        }
      },
    };
  }

  // --- lines on a 2-D canvas: fewer layers during a rotation, so that it follows the pointer

  function flatPainter() {
    // A canvas that was used for WebGL has no 2-D context, so a copy replaces it.
    const canvas = byId("contours").cloneNode();
    byId("contours").replaceWith(canvas);
    const context = canvas.getContext("2d");
    let colors = [];
    const inOrder = [...loops].sort((a, b) => a.layer - b.layer || a.first - b.first);
    return {
      canvas,
      paint(layerParts) { colors = layerParts.map(cssOf); },
      draw() {
        const [a, b] = axes(), mm = pixelsPerMm();
        const left = canvas.width / 2 + view.shift[0], top = canvas.height / 2 + view.shift[1];
        const step = Math.max(1, Math.ceil(points / (turning ? 60000 : 400000)));
        context.fillStyle = "#10151b";
        context.fillRect(0, 0, canvas.width, canvas.height);
        let layer = -1, support = false;
        for (const loop of inOrder) {
          if (loop.layer >= view.shown) break;
          if (loop.layer % step !== 0 || (loop.support && !view.supports)) continue;
          if (loop.layer !== layer || loop.support !== support) {
            if (layer >= 0) context.stroke();
            layer = loop.layer;
            support = loop.support;
            context.strokeStyle = support ? `rgb(${supportColor.join(" ")})` : colors[layer];
            context.beginPath();
          }
          for (let i = 3 * loop.first, end = i + 3 * loop.count; i < end; i += 3) {
            const x = positions[i], y = positions[i + 1], z = positions[i + 2];
            const right = left + (a[0] * x + a[1] * y) * mm, down = top - (b[0] * x + b[1] * y + b[2] * z) * mm;
            if (i === 3 * loop.first) context.moveTo(right, down); else context.lineTo(right, down);
          }
          context.closePath();
        }
        if (layer >= 0) context.stroke();
      },
    };
  }

  // --- marks: the box around the print, islands, the widest layers of voids, and contacts of supports

  function drawMarks() {
    const context = marks.getContext("2d"), dot = devicePixelRatio || 1, [w, d, h] = reach;
    context.clearRect(0, 0, marks.width, marks.height);
    context.font = `${12 * dot}px system-ui, sans-serif`;
    context.lineWidth = dot;
    context.strokeStyle = "rgb(223 228 234 / .28)";
    context.fillStyle = "rgb(223 228 234 / .8)";
    const line = (from, to, label) => {
      const p = project(from), q = project(to);
      context.beginPath();
      context.moveTo(...p);
      context.lineTo(...q);
      context.stroke();
      if (label && Math.hypot(p[0] - q[0], p[1] - q[1]) > 60 * dot) {
        const room = marks.width - context.measureText(label).width - 4 * dot;
        context.fillText(label, Math.min((p[0] + q[0]) / 2 + 8 * dot, room), (p[1] + q[1]) / 2 + 16 * dot);
      }
    };
    line([-w, -d, -h], [w, -d, -h], `x ${(2 * w).toFixed(1)} mm`);
    line([w, -d, -h], [w, d, -h], `y ${(2 * d).toFixed(1)} mm`);
    line([w, d, -h], [-w, d, -h]);
    line([-w, d, -h], [-w, -d, -h]);
    line([w, d, -h], [w, d, h], `z ${(2 * h).toFixed(1)} mm`);
    const top = data.heights_mm[view.shown - 1];
    if (view.supports) drawContacts(context, dot, top);
    places.forEach(([layer, x, y, z], i) => {
      if (z > top && i !== view.chosen) return;
      const p = project([x - middle[0], y - middle[1], z - middle[2]]);
      const chosen = i === view.chosen;
      context.beginPath();
      context.arc(p[0], p[1], (chosen ? 10 : places.length > 40 ? 3 : 5) * dot, 0, 2 * Math.PI);
      context.lineWidth = (chosen ? 3 : 1.5) * dot;
      context.strokeStyle = i < data.islands.length ? "#ff4d8d" : "#4db8ff";
      context.stroke();
      if (chosen || places.length <= 12) {
        context.fillStyle = i < data.islands.length ? "#ff9dc0" : "#a8dcff";
        context.fillText(`layer ${layer}`, p[0] + 12 * dot, p[1] + 4 * dot);
      }
    });
  }

  // Draws a dot for each contact, coloured by its cause, and a cross for a place that is not supported.
  function drawContacts(context, dot, top) {
    const size = (data.contacts.length > 200 ? 2 : 3) * dot;
    for (const [cause, x, y, z, , held] of data.contacts) {
      if (z > top) continue;
      const [across, down] = project([x - middle[0], y - middle[1], z - middle[2]]);
      context.fillStyle = context.strokeStyle = causeColors[cause];
      context.beginPath();
      if (held) {
        context.arc(across, down, size, 0, 2 * Math.PI);
        context.fill();
        continue;
      }
      context.lineWidth = 2 * dot;
      for (const sign of [1, -1]) {
        context.moveTo(across - 2 * size, down - 2 * size * sign);
        context.lineTo(across + 2 * size, down + 2 * size * sign);
      }
      context.stroke();
    }
  }

  function draw() {
    painter.draw();
    drawMarks();
  }

  // --- pointer and keys

  let turning = false;
  const fingers = new Map();
  const dot = () => devicePixelRatio || 1;
  const limit = (value, low, high) => Math.min(Math.max(value, low), high);
  function zoomBy(factor, x, y) {
    const zoom = limit(view.zoom * factor, 0.2, 60), real = zoom / view.zoom;
    // The point under the pointer stays in place.
    const from = [x * dot() - marks.width / 2, y * dot() - marks.height / 2];
    view.shift = view.shift.map((shift, i) => from[i] + (shift - from[i]) * real);
    view.zoom = zoom;
    redraw();
  }
  function turnBy(right, down) {
    view.yaw += right;
    view.pitch = limit(view.pitch + down, -Math.PI / 2, Math.PI / 2);
    redraw();
  }
  marks.addEventListener("pointerdown", (event) => {
    marks.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    turning = true;
  });
  marks.addEventListener("pointermove", (event) => {
    const from = fingers.get(event.pointerId);
    if (!from) return;
    const to = [event.offsetX, event.offsetY];
    const other = [...fingers].find(([id]) => id !== event.pointerId);
    fingers.set(event.pointerId, to);
    if (other) {
      const apart = (p) => Math.max(Math.hypot(p[0] - other[1][0], p[1] - other[1][1]), 1);
      view.shift = view.shift.map((shift, i) => shift + (to[i] - from[i]) / 2 * dot());
      zoomBy(apart(to) / apart(from), (to[0] + other[1][0]) / 2, (to[1] + other[1][1]) / 2);
    } else if (event.shiftKey || event.buttons === 2 || event.buttons === 4) {
      view.shift = view.shift.map((shift, i) => shift + (to[i] - from[i]) * dot());
      redraw();
    } else {
      turnBy((to[0] - from[0]) * 0.01, (to[1] - from[1]) * 0.01);
    }
  });
  const lifted = (event) => {
    fingers.delete(event.pointerId);
    turning = fingers.size > 0;
    redraw();
  };
  marks.addEventListener("pointerup", lifted);
  marks.addEventListener("pointercancel", lifted);
  marks.addEventListener("contextmenu", (event) => event.preventDefault());
  marks.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomBy(Math.exp(-limit(event.deltaY, -240, 240) * 0.002), event.offsetX, event.offsetY);
  }, {passive: false});
  const look = (name) => {
    Object.assign(view, views[name], {zoom: 1, shift: [0, 0]});
    redraw();
  };
  marks.addEventListener("dblclick", () => look("corner"));
  marks.addEventListener("keydown", (event) => {
    const step = 0.1, center = [marks.clientWidth / 2, marks.clientHeight / 2];
    const keys = {
      ArrowLeft: () => turnBy(-step, 0), ArrowRight: () => turnBy(step, 0),
      ArrowUp: () => turnBy(0, -step), ArrowDown: () => turnBy(0, step),
      "+": () => zoomBy(1.2, ...center), "-": () => zoomBy(1 / 1.2, ...center),
    };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => look(button.dataset.view));
  }
  for (const row of document.querySelectorAll("[data-mark]")) {
    row.addEventListener("click", () => {
      const mark = Number(row.dataset.mark);
      view.chosen = view.chosen === mark ? -1 : mark;
      for (const each of document.querySelectorAll("[data-mark]")) {
        each.classList.toggle("chosen", Number(each.dataset.mark) === view.chosen);
      }
      redraw();
    });
  }

  // --- controls: the layers shown, and their colours

  const cut = byId("cut");
  cut.max = String(data.layers.length);
  cut.min = "1";
  cut.value = cut.max;
  const showUpTo = () => {
    view.shown = Number(cut.value);
    byId("cut-text").textContent = `${data.heights_mm[view.shown - 1].toFixed(2)} mm, layer ${data.layers[view.shown - 1] + 1}`;
    redraw();
  };
  cut.addEventListener("input", showUpTo);
  const quantity = byId("quantity");
  data.quantities.forEach((each, i) => quantity.add(new Option(each.name, String(i))));
  quantity.addEventListener("change", () => chooseQuantity(Number(quantity.value)));

  const supports = byId("supports");
  byId("supports-tool").hidden = data.contacts.length === 0;
  supports.addEventListener("change", () => {
    view.supports = supports.checked;
    redraw();
  });

  const painter = glPainter() || flatPainter();
  new ResizeObserver(() => {
    for (const canvas of [painter.canvas, marks]) {
      canvas.width = Math.max(1, Math.round(stage.clientWidth * dot()));
      canvas.height = Math.max(1, Math.round(stage.clientHeight * dot()));
    }
    draw();
  }).observe(stage);
  const step = data.layers.length > 1 ? data.layers[1] - data.layers[0] : 1;
  byId("note").textContent = (step > 1 ? `One layer in ${step}. ` : "") +
    "Drag turns, wheel zooms, shift-drag moves." + (places.length > 0 ? " Rings: islands; blue: suction cups and resin traps." : "");
  chooseQuantity(0);
  showUpTo();
})();
