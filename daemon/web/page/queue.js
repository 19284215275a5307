// The queue: waiting jobs, each with its outlook, its settings, and buttons to print, move and remove it.
import {$, button, call, confirmed, duration, element, get, keepFocus, live, only, withoutCommand} from "./base.js";
import {JobPanel} from "./job.js";

const STATES = {unchecked: "not checked yet", checking: "is being checked", analyzing: "is being analyzed", unaccepted: "waits for you",
  postponed: "waits for memory", leaving: "is being removed", ready: ""};
const items = new Map();  // by the job's file
let shownFor = null;      // the part of the status with which the queue was shown
let opened = "";          // name of a job whose panel opens when it appears

// Has the queue asked for again, now.
export function refreshQueue() {
  shownFor = null;
  if (live.status) showQueue();
}

// Opens the panel of a job that has just been uploaded, once it is in the queue.
export function openJob(name) {
  opened = name;
  refreshQueue();
}

export function queueOf(status) {
  const key = JSON.stringify([status.queued, status.unaccepted, status.postponed, status.incomplete, status.state, status.waiting_for]);
  if (key === shownFor) return;
  shownFor = key;
  showQueue();
}

export function forgetQueue() {
  shownFor = null;
}

class JobItem {
  constructor(file) {
    this.file = file;
    this.name = element("div", "name");
    this.more = element("div", "more");
    this.texts = element("div");
    this.buttons = element("div", "row");
    this.error = element("p", "error");
    this.error.setAttribute("role", "alert");
    this.panel = new JobPanel(file);
    this.toggle = button("Details", "", () => this.open(this.panel.element.hidden));
    this.toggle.setAttribute("aria-expanded", "false");
    this.element = element("li", "", "", element("div", "what", "", this.name, this.more, this.texts), this.buttons, this.error, this.panel.element);
  }

  open(open) {
    this.panel.show(open);
    this.toggle.setAttribute("aria-expanded", String(open));
  }

  // Takes the job as contourd reports it.
  update(job) {
    const before = this.job;
    this.job = job;
    this.name.textContent = job.job;
    this.more.textContent = [STATES[job.state] ?? job.state, job.resin, job.layers && `${job.layers} layers`, job.print_time_s && duration(job.print_time_s),
      job.resin_ml !== null && `${job.resin_ml.toFixed(1)} ml`].filter(Boolean).join(" \u00b7 ");
    const asks = job.asks.filter((each) => each !== "to_be_confirmed");
    const waits = job.state === "unaccepted" && asks.length === 0 ? "" : job.waiting_for && withoutCommand(job.waiting_for);
    this.texts.replaceChildren(...[waits, ...job.warnings.map(withoutCommand)].filter(Boolean).map((text) => element("div", "more", text)));
    const key = (each) => each && JSON.stringify([each.state, each.number, each.job, each.asks]);
    if (key(before) !== key(job)) this.showButtons(job, asks);
    this.toggle.setAttribute("aria-label", `Details of ${job.job}`);
    this.panel.update(job);
    if (opened === job.job) {
      opened = "";
      this.open(true);
    }
  }

  showButtons(job, asks) {
    const focused = this.buttons.contains(document.activeElement) ? document.activeElement.textContent : "";
    const made = [];
    if (job.state === "unaccepted")
      made.push(only("print", button(asks.length ? "Print anyway" : "Print", `${asks.length ? "Print anyway:" : "Print"} ${job.job}`, async () => {
        if (asks.length === 0 || await confirmed(`Print ${job.job} anyway?`)) this.control("accept", {job: this.file});
      }, asks.length ? "quiet" : "main")));
    made.push(this.toggle);
    if (job.number > 1) made.push(only("print", button("\u2191", `Move ${job.job} up`, () => this.control("queue_move", {job: this.file, to: job.number - 1}))));
    made.push(only("print", button("\u2715", `Remove ${job.job}`, async () => {
      if (await confirmed(`Remove ${job.job} from the queue?`)) this.control("queue_remove", {job: this.file});
    })));
    this.buttons.replaceChildren(...made);
    if (focused) (made.find((each) => each.textContent === focused) || this.toggle).focus();
  }

  async control(method, parameters) {
    this.error.textContent = "";
    try {
      await call(method, parameters);
      refreshQueue();
    } catch (error) {
      this.error.textContent = error.message;
    }
  }
}

function itemOf(job) {
  if (!items.has(job.file)) items.set(job.file, new JobItem(job.file));
  const item = items.get(job.file);
  item.update(job);
  return item.element;
}

// Puts the elements into the list. One that stays is not moved, so that an input in it stays as it is.
function place(list, elements) {
  for (const each of [...list.children]) if (!elements.includes(each)) each.remove();
  elements.forEach((each, i) => {
    if (list.children[i] !== each) list.insertBefore(each, list.children[i] || null);
  });
}

async function showQueue() {
  try {
    const queue = await get("/api/queue");
    for (const file of [...items.keys()]) if (!queue.jobs.some((job) => job.file === file)) items.delete(file);
    const arriving = queue.arriving.map((name) => element("li", "", "", element("div", "what", "", element("div", "name", name), element("div", "more", "arriving"))));
    const more = queue.more > 0 ? [element("li", "more", `and ${queue.more} more`)] : [];
    const shown = [...queue.jobs.map(itemOf), ...arriving, ...more];
    keepFocus(() => place($("queue"), shown), () => [document.querySelector("#queue button[aria-expanded]"), $("queue-title")]);
    $("queue-empty").hidden = queue.jobs.length + arriving.length > 0;
    if (queue.jobs.some((job) => ["unchecked", "checking", "analyzing"].includes(job.state))) setTimeout(refreshQueue, 1500);
  } catch {
    shownFor = null;  // the next status tries again
  }
}
