// The panel of a waiting job: its outlook, its picture with the supports, and the settings of its ticket.
import {button, call, choice, duration, element, facts, field, get, keepFocus, only, send} from "./base.js";
import {refreshQueue} from "./queue.js";

const AXES = {"+x": {x: 1}, "-x": {x: -1}, "+y": {y: 1}, "-y": {y: -1}, "-z": {z: -1}};
const KEEP = "as in the ticket";
let known = null, knownAt = 0;

// Returns the resin profiles, asked for once a minute at most.
export async function resins() {
  if (!known || performance.now() - knownAt > 60000) {
    known = get("/api/resins");
    knownAt = performance.now();
    known.catch(() => { known = null; });
  }
  return (await known).resins;
}

function upOf(ticket) {
  if (ticket.rotation_deg) return KEEP;
  if (!ticket.up) return "";
  if (typeof ticket.up === "string") return ticket.up;
  const axis = Object.keys(AXES).find((name) => JSON.stringify(AXES[name]) === JSON.stringify(ticket.up));
  return axis || KEEP;
}

// Returns the pairs, and one more for a setting of the ticket that they do not have.
const withKept = (pairs, chosen) => chosen === KEEP ? [...pairs, [KEEP, KEEP]] : pairs;

// The fields of a ticket. Settings that have no field stay as they are.
class TicketForm {
  constructor(ticket, job, profiles) {
    this.ticket = ticket || {};
    const usual = profiles.find((each) => each.is_default), names = profiles.filter((each) => !each.trouble).map((each) => each.resin);
    const own = this.ticket.resin, up = upOf(this.ticket), supports = typeof this.ticket.supports === "object" ? KEEP : this.ticket.supports || "";
    this.resin = choice([["", usual ? `${usual.resin} (the printer's)` : "the printer's"], ...[...new Set([...names, ...(own ? [own] : [])])].map((name) => [name, name])], own || "");
    this.layer = element("input");
    Object.assign(this.layer, {type: "number", min: 1, max: 500, step: "any", value: this.ticket.layer_height_um ?? ""});
    const shown = () => {
      const profile = profiles.find((each) => each.resin === (this.resin.value || (usual && usual.resin)));
      this.layer.placeholder = profile && profile.layer_height_um ? profile.layer_height_um : "";
      this.range.textContent = profile && profile.layer_height_um ? `${profile.layer_height_min_um} to ${profile.layer_height_max_um}; empty: ${this.ticket.adaptive_layers ? "adaptive" : profile.layer_height_um}` : "";
    };
    this.supports = choice(withKept([["", "as the printer is set"], ["auto", "auto"], ["on", "on"], ["off", "off"], ["in the file", "in the file"]], supports), supports);
    this.up = choice(withKept([["", "as in the file"], ["auto", "the printer chooses"], ["fast", "low, for a fast print"], ["clean", "few supports"], ["safe", "little peel force"],
      ...Object.keys(AXES).map((axis) => [axis, `${axis} up`])], up), up);
    this.copies = element("input");
    Object.assign(this.copies, {type: "number", min: 1, max: 100, step: 1, value: this.ticket.copies ?? 1});
    this.wall = element("input");
    Object.assign(this.wall, {type: "number", min: 0.2, max: 30, step: "any", placeholder: "solid", value: this.ticket.hollow ? this.ticket.hollow.wall_mm ?? 2 : ""});
    this.unit = choice([["", "as in the file"], ...["mm", "cm", "m", "um", "inch", "foot"].map((unit) => [unit, unit])], this.ticket.unit || "");
    const layer = field("Layer height in \u00b5m", this.layer, " ");
    this.range = layer.lastChild;
    this.resin.addEventListener("change", shown);
    shown();
    this.fields = [field("Resin", this.resin), layer, field("Supports", this.supports), field("Orientation", this.up), field("Copies", this.copies), field("Hollow, with walls of (mm)", this.wall)];
    if (job.asks.includes("unit_in_doubt") || this.ticket.unit) this.fields.push(field("Unit of the file", this.unit));
  }

  // Returns the ticket with the values of the fields. A job that waits for the user's word goes on waiting: with the new outlook.
  value(job) {
    const ticket = {...this.ticket};
    const set = (key, value) => {
      if (value === "" || value === undefined) delete ticket[key];
      else ticket[key] = value;
    };
    set("resin", this.resin.value);
    set("layer_height_um", this.layer.value === "" ? "" : Number(this.layer.value));
    if (this.layer.value !== "") delete ticket.adaptive_layers;
    if (this.supports.value !== KEEP) set("supports", this.supports.value);
    if (this.up.value !== KEEP) {
      delete ticket.rotation_deg;
      set("up", AXES[this.up.value] || this.up.value);
      if (typeof ticket.up !== "string") delete ticket.keep_clean;
    }
    set("copies", this.copies.value === "" || this.copies.value === "1" ? "" : Number(this.copies.value));
    set("hollow", this.wall.value === "" ? "" : {...ticket.hollow, wall_mm: Number(this.wall.value)});
    set("unit", this.unit.value);
    if (job.state === "unaccepted") ticket.confirm = true;
    return ticket;
  }
}

export class JobPanel {
  constructor(file) {
    this.file = file;
    this.facts = element("div");
    this.picture = element("img", "preview");
    Object.assign(this.picture, {width: 720, height: 720, hidden: true});
    this.drawing = element("p", "more");
    this.drawing.tabIndex = -1;
    this.form = only("print", element("form", "settings"));
    this.element = element("div", "panel", "", this.facts, this.drawing, this.picture, this.form);
    this.element.hidden = true;
    this.picture.addEventListener("load", () => {
      this.picture.hidden = false;
      this.drawing.textContent = "";
    });
    this.picture.addEventListener("error", () => this.explain());
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.apply();
    });
  }

  show(open) {
    this.element.hidden = !open;
    if (open && this.job) {
      this.showPicture();
      this.showForm();
    }
  }

  update(job) {
    this.job = job;
    this.picture.alt = `${job.job} with its supports`;
    const supports = job.supports;
    this.facts.replaceChildren(facts([
      ["Time", job.print_time_s && duration(job.print_time_s)],
      ["Resin", job.resin_ml !== null ? `${job.resin_ml.toFixed(2)} ml of ${job.resin}` : job.resin],
      ["Layers", job.layers && `${job.layers} of ${job.thinnest_layer_um === job.thickest_layer_um ? "" : `${job.thinnest_layer_um} to `}${job.thickest_layer_um} \u00b5m`],
      ["Height", job.height_mm && `${job.height_mm.toFixed(2)} mm`],
      ["Parts", job.parts && String(job.parts)],
      ["Supports", supports && (supports.carriers && !supports.contacts ? "in the file" : `${supports.contacts} contacts`)],
    ]));
    if (!this.element.hidden) this.showPicture();
  }

  // Has the picture drawn if the job was checked and is another than that of the last picture.
  showPicture() {
    const job = this.job, drawn = job.layers === null ? null : JSON.stringify([job.layers, job.height_mm, job.parts, job.supports, job.resin, job.print_time_s]);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    if (drawn === null) {
      this.picture.hidden = true;
      this.drawing.textContent = "";
      return;
    }
    this.tries = 0;
    keepFocus(() => this.drawing.replaceChildren("The picture is being drawn."), () => [this.drawing]);
    this.picture.src = this.address();
  }

  address() {
    return `/api/preview?job=${encodeURIComponent(this.file)}&at=${Date.now()}`;
  }

  // Tells why there is no picture, unless a later try brings one: another job may have had to be read first.
  async explain() {
    this.picture.hidden = true;
    try {
      await send(this.address());
      this.picture.src = this.address();
    } catch (error) {
      if (error.message.endsWith("try again") && ++this.tries < 5) return setTimeout(() => { this.picture.src = this.address(); }, 2000);
      this.drawing.replaceChildren(`No picture: ${error.message} `, button("Try again", "Draw the picture again", () => {
        this.drawn = undefined;
        this.showPicture();
      }));
    }
  }

  // Fills the form with the ticket, unless the user is at it.
  async showForm() {
    if (this.fields) return;
    try {
      const [{ticket}, profiles] = await Promise.all([get(`/api/ticket?job=${encodeURIComponent(this.file)}`), resins()]);
      this.fields = new TicketForm(ticket, this.job, profiles);
      const submit = element("button", "", "Apply");
      submit.type = "submit";
      this.error = element("p", "error");
      this.error.setAttribute("role", "alert");
      keepFocus(() => this.form.replaceChildren(...this.fields.fields, this.error, element("div", "buttons", "", submit)), () => [submit]);
    } catch (error) {
      this.fields = null;
      keepFocus(() => this.form.replaceChildren(element("p", "more", error.message)), () => [this.drawing]);
    }
  }

  async apply() {
    this.error.textContent = "";
    try {
      await call("queue_ticket", {job: this.file, ticket: this.fields.value(this.job)});
      this.fields = null;
      await this.showForm();
      refreshQueue();
    } catch (error) {
      this.error.textContent = error.message;
    }
  }
}
