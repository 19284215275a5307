// The printer's page: shows each status that the server sends, and passes on what the user wants.
"use strict";

const $ = (id) => document.getElementById(id);
let status = null, receivedAt = 0, events = null, maskOf = null, maskAt = 0, historyBefore = null, queueKey = null, lastKey = null;

// Makes an element with a class, text and children. Texts of strangers never become markup.
function element(tag, className, text, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

// Sends a request; throws an Error with the server's sentence if it is refused.
async function send(path, options) {
  let reply;
  try {
    reply = await fetch(path, options);
  } catch {
    throw new Error("the printer cannot be reached");
  }
  if (reply.status === 401 && path !== "/api/login") showLogin();
  if (!reply.ok) throw new Error((await reply.text()).trim() || `the printer answers ${reply.status}`);
  return reply;
}
const get = async (path) => (await send(path)).json();
const call = (method, parameters = {}) => send(`/api/call/${method}`, {method: "POST", body: JSON.stringify(parameters)});

// --- login

function showLogin() {
  if (events) events.close();
  events = null;
  $("page").hidden = $("logout").hidden = true;
  $("login").hidden = false;
  $("password").focus();
}

$("login-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  $("login-error").textContent = "";
  try {
    await send("/api/login", {method: "POST", body: JSON.stringify({password: $("password").value})});
    $("password").value = "";
    open();
  } catch (error) {
    $("login-error").textContent = error.message;
    $("password").select();
  }
});

$("logout").addEventListener("click", async () => {
  await send("/api/logout", {method: "POST"}).catch(() => {});
  showLogin();
});

// --- status

function open() {
  $("login").hidden = true;
  $("page").hidden = $("logout").hidden = false;
  queueKey = lastKey = null;
  events = new EventSource("/api/events");
  events.onmessage = (event) => show(JSON.parse(event.data));
  events.onerror = () => {
    showConnection("The connection to the printer is lost. Trying again.");
    // A closed source was refused, such as after the end of the session.
    if (events && events.readyState === EventSource.CLOSED) setTimeout(start, 3000);
  };
}

function showConnection(text) {
  $("connection").hidden = !text;
  $("connection").textContent = text;
}

function show(now) {
  if (now.unreachable) {
    showConnection(`contourd does not answer: ${now.unreachable}`);
    return;
  }
  showConnection("");
  status = now;
  receivedAt = performance.now();
  document.title = now.job ? `${now.job.name} - ${now.printer}` : now.printer;
  $("printer").textContent = now.printer;
  showNotices();
  showPrint();
  showLight();
  showMask();
  const queue = JSON.stringify([now.queued, now.unaccepted, now.postponed, now.incomplete, now.state, now.waiting_for]);
  if (queue !== queueKey) showQueue();
  queueKey = queue;
  const last = JSON.stringify(now.last);
  if (last !== lastKey) showHistory(false);
  lastKey = last;
}

function showNotices() {
  const texts = [status.not_ready_reason, status.held, status.interrupted && `A power cut ended the print of ${status.interrupted.job} at layer ${status.interrupted.layer}; decide at the printer (contourctl go-on).`,
    status.job && status.job.interruption, status.manual.problem, status.waiting_for, ...status.reminders].filter(Boolean);
  const shown = [...new Set(texts)];
  if (shown.join("\n") !== [...$("notices").children].map((each) => each.textContent).join("\n"))
    $("notices").replaceChildren(...shown.map((text) => element("li", "", text)));
}

const printing = () => status.job && status.job.layers !== undefined;

function showPrint() {
  const job = status.job;
  setText("state", status.state === "idle" && status.plate === "occupied" ? "part on the plate" : status.state);
  setText("job", job ? job.name : status.plate === "occupied" ? status.plate_job || "" : "");
  $("printing").hidden = !printing();
  const waits = ["paused", "held"].includes(status.state);
  $("pause").hidden = !printing() || waits || job.pause_pending;
  $("resume").hidden = !(printing() && (waits || job.pause_pending || job.interruption));
  $("resume").textContent = job && job.pause_pending && !waits ? "Do not pause" : "Resume";
  $("cancel").hidden = !job;
  $("cleared").hidden = Boolean(job) || (status.plate !== "occupied" && !status.held);
  if (!printing()) return;
  $("progress").max = job.layers || 1;
  $("progress").value = job.layers_done;
  setText("layer", `${job.layer} of ${job.layers}`);
  setText("height", `${job.height_mm.toFixed(2)} of ${job.total_height_mm.toFixed(2)} mm`);
  setText("resin", job.analysis ? `${job.analysis.resin_ml.toFixed(1)} ml` : "\u2013");
  showTimes();
}

// Sets a text if it differs, so that screen readers are not told again.
function setText(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

function duration(seconds) {
  const whole = Math.max(0, Math.round(seconds)), minutes = Math.floor(whole / 60);
  if (minutes >= 60) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
  return minutes > 0 ? `${minutes} min ${String(whole % 60).padStart(2, "0")} s` : `${whole} s`;
}

function showTimes() {
  if (!status || !printing()) return;
  const passed = ["paused", "held"].includes(status.state) ? 0 : (performance.now() - receivedAt) / 1000;
  const left = Math.max(0, status.job.time_left_s - passed), end = new Date(Date.now() + 1000 * left);
  setText("left", duration(left));
  setText("elapsed", duration(status.job.elapsed_s + passed));
  const day = end.toDateString() === new Date().toDateString() ? {} : {weekday: "short"};
  setText("ends", end.toLocaleString([], {...day, hour: "2-digit", minute: "2-digit"}));
}
setInterval(showTimes, 1000);

function showLight() {
  const on = !status.dark;
  $("light").classList.toggle("on", on);
  setText("light-text", on ? "light on" : "light off");
}

function showMask() {
  if (!printing()) {
    $("mask").hidden = true;
    maskOf = null;
    return;
  }
  const wanted = `${status.job.name} ${status.job.layer}`;
  if (!["exposing", "rising", "igniting"].includes(status.state) || wanted === maskOf || performance.now() - maskAt < 1000) return;
  maskOf = wanted;
  maskAt = performance.now();
  $("mask").alt = `Mask of layer ${status.job.layer}`;
  $("mask").src = `/api/mask?${Date.now()}`;
}
$("mask").addEventListener("load", () => { $("mask").hidden = !status || !printing(); });
$("mask").addEventListener("error", () => { maskOf = null; });

// --- control

function confirmed(question) {
  $("question").textContent = question;
  $("confirm").returnValue = "no";
  $("confirm").showModal();
  return new Promise((resolve) => {
    $("confirm").addEventListener("close", () => resolve($("confirm").returnValue === "yes"), {once: true});
  });
}

async function control(method, parameters) {
  $("control-error").textContent = "";
  try {
    await call(method, parameters);
    queueKey = null;
    if (status) showQueue();
  } catch (error) {
    $("control-error").textContent = error.message;
  }
}

$("pause").addEventListener("click", () => control("pause"));
$("resume").addEventListener("click", () => control("resume"));
$("cancel").addEventListener("click", async () => {
  if (await confirmed(`Cancel the print${status.job ? ` of "${status.job.name}"` : ""}? It cannot be continued.`)) control("cancel");
});
$("cleared").addEventListener("click", async () => {
  if (await confirmed("Is the plate free of parts, and the printer ready? The next job begins at once.")) control("plate_cleared");
});

// --- queue

function button(text, label, action) {
  const made = element("button", "quiet", text);
  made.type = "button";
  made.setAttribute("aria-label", label);
  made.addEventListener("click", action);
  return made;
}

function jobItem(job) {
  const facts = [job.state === "ready" ? "" : job.state, job.resin, job.layers && `${job.layers} layers`, job.print_time_s && duration(job.print_time_s),
    job.resin_ml && `${job.resin_ml.toFixed(1)} ml`].filter(Boolean).join(" \u00b7 ");
  const item = element("li", "", "", element("div", "what", "", element("div", "name", job.job), element("div", "more", facts)));
  for (const text of [job.waiting_for, ...job.warnings].filter(Boolean)) item.firstChild.append(element("div", "more", text));
  if (job.state === "unaccepted")
    item.append(button("Print anyway", `Print ${job.job} anyway`, async () => {
      if (await confirmed(`Print ${job.job} as it is?`)) control("accept", {job: job.file});
    }));
  if (job.number > 1) item.append(button("\u2191", `Move ${job.job} up`, () => control("queue_move", {job: job.file, to: job.number - 1})));
  item.append(button("\u2715", `Remove ${job.job}`, async () => {
    if (await confirmed(`Remove ${job.job} from the queue?`)) control("queue_remove", {job: job.file});
  }));
  return item;
}

async function showQueue() {
  try {
    const queue = await get("/api/queue");
    const arriving = queue.arriving.map((name) => element("li", "", "", element("div", "what", "", element("div", "name", name), element("div", "more", "arriving"))));
    $("queue").replaceChildren(...queue.jobs.map(jobItem), ...arriving);
    if (queue.more > 0) $("queue").append(element("li", "more", `and ${queue.more} more`));
    $("queue-empty").hidden = queue.jobs.length + arriving.length > 0;
    if (queue.jobs.some((job) => ["unchecked", "checking", "analyzing"].includes(job.state))) setTimeout(() => { queueKey = null; }, 1500);
  } catch {
    queueKey = null;  // the next status tries again
  }
}

// --- upload

const waiting = [];
let uploading = false;

function add(files) {
  for (const file of files) {
    const bar = element("progress"), text = element("div", "more", "waits");
    bar.max = 1;
    bar.value = 0;
    bar.setAttribute("aria-label", `Upload of ${file.name}`);
    const item = element("li", "", "", element("div", "what", "", element("div", "name", file.name), bar, text));
    $("uploads").append(item);
    waiting.push({file, bar, text, item});
  }
  uploadNext();
}

function uploadNext() {
  if (uploading || waiting.length === 0) return;
  uploading = true;
  const {file, bar, text, item} = waiting.shift(), request = new XMLHttpRequest();
  const ended = (sentence) => {
    uploading = false;
    bar.remove();
    text.textContent = sentence;
    if (sentence) {
      text.className = "error";
      item.append(button("\u2715", "Close", () => item.remove()));
    } else {
      item.remove();
    }
    queueKey = null;
    uploadNext();
  };
  request.open("POST", `/api/upload?name=${encodeURIComponent(file.name)}`);
  request.upload.onprogress = (event) => {
    bar.value = event.total ? event.loaded / event.total : 0;
    text.textContent = `${Math.round(100 * bar.value)} % of ${(event.total / 1048576).toFixed(1)} MiB`;
  };
  request.onload = () => {
    if (request.status === 401) showLogin();
    ended(request.status === 201 ? "" : request.responseText.trim() || `the printer answers ${request.status}`);
  };
  request.onerror = () => ended(`${file.name} did not arrive: the connection was lost`);
  request.send(file);
}

$("files").addEventListener("change", () => {
  add($("files").files);
  $("files").value = "";
});
for (const [name, over] of [["dragover", true], ["dragleave", false], ["drop", false]])
  document.addEventListener(name, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", over && !$("page").hidden);
    if (name === "drop" && !$("page").hidden) add(event.dataTransfer.files);
  });

// --- history

function historyItem(job) {
  const ended = new Date(job.ended).toLocaleString([], {dateStyle: "medium", timeStyle: "short"});
  const facts = [ended, job.layers_exposed ? `${job.layers_exposed} layers` : "", job.print_time_s ? duration(job.print_time_s) : "",
    job.resin_ml ? `${job.resin_ml.toFixed(1)} ml` : "", job.resin].filter(Boolean).join(" \u00b7 ");
  const item = element("li", "", "", element("div", "what", "", element("div", "name", job.job), element("div", "more", facts)), element("span", job.outcome === "done" ? "faint" : "error", job.outcome));
  if (job.reason) item.firstChild.append(element("div", "more", job.reason));
  return item;
}

async function showHistory(earlier) {
  try {
    const reply = await get(earlier ? `/api/history?before=${historyBefore}` : "/api/history");
    const items = reply.ended.reverse().map(historyItem);
    if (earlier) $("history").append(...items);
    else $("history").replaceChildren(...items);
    historyBefore = reply.before;
    $("earlier").hidden = reply.before === null;
    $("history-empty").hidden = $("history").children.length > 0;
  } catch {
    lastKey = null;
  }
}
$("earlier").addEventListener("click", () => showHistory(true));

// --- start

async function start() {
  if (events) events.close();
  events = null;
  const reply = await fetch("/api/status").catch(() => null);
  if (reply && reply.status === 401) return showLogin();
  open();
}
start();
