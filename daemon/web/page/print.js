// The print: its state, progress, mask and notices, and the buttons that control it.
import {$, call, confirmed, duration, element, keepFocus, live, setText, withoutCommand} from "./base.js";
import {showChanges} from "./change.js";
import {refreshQueue} from "./queue.js";

let maskOf = null, maskAt = 0, pictureOf = null;
let focused = null;  // the element that had the focus before the state became unknown

export const printing = () => live.status && live.status.job && live.status.job.layers !== undefined;

export function showNow() {
  keepFocus(showAll, (held) => [held.closest("#change") && document.querySelector("#change summary"), $("resume"), $("pause"), $("state")]);
  if (focused && document.activeElement === document.body && focused.checkVisibility()) focused.focus();
  focused = null;
}

function showAll() {
  const status = live.status;
  document.body.classList.add("known");
  document.title = status.job ? `${status.job.name} - ${status.printer}` : status.printer;
  $("printer").textContent = status.printer;
  showNotices(status);
  showPrint(status);
  announce(status);
  showLight(status);
  showByHand(status);
  showMask(status);
  showPicture(status);
  showChanges(printing());
}

function showNotices(status) {
  const texts = [status.not_ready_reason, status.held, status.interrupted && `A power cut, a crash or a kill ended the print of ${status.interrupted.job} at layer ${status.interrupted.layer}; decide at the printer (contourctl resume, rescue or plate-cleared).`,
    status.job && status.job.interruption, ...(status.job && status.job.warnings || []), status.manual.problem, status.waiting_for && withoutCommand(status.waiting_for).replace(/^to be confirmed$/, ""), ...status.reminders].filter(Boolean);
  const shown = [...new Set(texts)];
  if (shown.join("\n") !== [...$("notices").children].map((each) => each.textContent).join("\n"))
    $("notices").replaceChildren(...shown.map((text) => element("li", "", text)));
}

function showPrint(status) {
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

function showTimes() {
  if (!printing()) return;
  const {status, receivedAt} = live;
  const passed = ["paused", "held"].includes(status.state) ? 0 : (performance.now() - receivedAt) / 1000;
  const left = Math.max(0, status.job.time_left_s - passed), end = new Date(Date.now() + 1000 * left);
  setText("left", duration(left));
  setText("elapsed", duration(status.job.elapsed_s + passed));
  const day = end.toDateString() === new Date().toDateString() ? {} : {weekday: "short"};
  setText("ends", end.toLocaleString([], {...day, hour: "2-digit", minute: "2-digit"}));
}
setInterval(showTimes, 1000);

// Has screen readers say that a print begins, pauses, goes on or ends, but not each step of each layer. Problems are among the notices.
function announce(status) {
  const job = status.job, doing = ["paused", "held"].includes(status.state) ? status.state : printing() ? "printing" : job ? "preparing" : $("state").textContent;
  setText("announced", job ? `${doing}: ${job.name}` : doing);
}

// Shows that the printer's state is unknown, and hides what depends on it, until the next status.
export function showUnknown() {
  focused = focused || document.activeElement;
  document.body.classList.remove("known");
  setText("state", "unknown");
  setText("announced", "");
  $("light").classList.remove("on");
  setText("light-text", "light unknown");
}

function showLight(status) {
  const on = !status.dark;
  $("light").classList.toggle("on", on);
  setText("light-text", on ? "light on" : "light off");
}

function showMask(status) {
  if (!printing()) {
    $("mask").hidden = $("mask-told").hidden = true;
    maskOf = null;
    return;
  }
  $("mask-told").hidden = !$("mask").hidden;
  const wanted = `${status.job.name} ${status.job.layer}`;
  if (!["exposing", "rising", "igniting"].includes(status.state) || wanted === maskOf || performance.now() - maskAt < 1000) return;
  maskOf = wanted;
  maskAt = performance.now();
  $("mask").alt = `Mask of layer ${status.job.layer}`;
  $("mask").src = `/api/mask?${Date.now()}`;
}
$("mask").addEventListener("load", () => {
  $("mask").hidden = !printing();
  $("mask-told").hidden = true;
});
$("mask").addEventListener("error", () => { maskOf = null; });

// Shows the last picture of the user's camera.
function showPicture(status) {
  const camera = printing() && status.camera && status.camera.job === status.job.name ? status.camera : null, layer = camera && camera.last_layer;
  $("picture-told").hidden = !(camera && camera.trouble);
  if (camera && camera.trouble) setText("picture-told", `The camera has failed ${camera.failed === 1 ? "once" : `${camera.failed} times`}, at first because ${camera.trouble}.`);
  if (!layer) {
    $("picture").hidden = true;
    pictureOf = null;
    return;
  }
  const wanted = `/api/picture?job=${encodeURIComponent(status.job.name)}&layer=${layer}`;
  if (wanted === pictureOf) return;
  pictureOf = wanted;
  $("picture").alt = `Picture after layer ${layer}`;
  $("picture").src = wanted;
}
$("picture").addEventListener("load", () => { $("picture").hidden = !printing(); });
$("picture").addEventListener("error", () => { $("picture").hidden = true; });

async function control(method) {
  $("control-error").textContent = "";
  try {
    await call(method);
    refreshQueue();
  } catch (error) {
    $("control-error").textContent = error.message;
  }
}

// What somebody does by hand, at the printer or as service, can be ended by everyone who may print.
function showByHand(status) {
  const {manual} = status, lit = !manual.dark && !status.job;
  $("by-hand").hidden = manual.state === "idle" && !lit;
  if (!$("by-hand").hidden) setText("by-hand-text", `By hand: ${manual.state}${lit ? "; the light is or may be on" : ""}.`);
}
$("stop-hand").addEventListener("click", () => control("stop"));
$("dark-hand").addEventListener("click", () => control("light_off"));

$("pause").addEventListener("click", () => control("pause"));
$("resume").addEventListener("click", () => control("resume"));
$("cancel").addEventListener("click", async () => {
  const job = live.status && live.status.job;
  if (await confirmed(`Cancel the print${job ? ` of "${job.name}"` : ""}? A cancelled print cannot be resumed.`)) control("cancel");
});
$("cleared").addEventListener("click", async () => {
  if (await confirmed("Is the plate free of parts, and the printer ready? The next job begins at once.")) control("plate_cleared");
});
