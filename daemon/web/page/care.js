// The printer's care: resin in the vat, wear of lamp, film and vat, and the resin profiles with their calibrations.
import {$, button, call, confirmed, element, facts, field, get, keepFocus, only} from "./base.js";
import {resins} from "./job.js";

const NAMES = {lamp: "Lamp", film: "Film", vat: "Vat"};

// Runs a change; tells the refusal, if there is one, and shows everything again otherwise.
async function change(method, parameters) {
  $("care-error").textContent = "";
  try {
    await call(method, parameters);
    showCare();
  } catch (error) {
    $("care-error").textContent = error.message;
  }
}

// Returns "12 of 400 h" and the like.
const share = (used, limit, unit) => `${used}${limit === null ? "" : ` of ${limit}`} ${unit}`;

function partItem(part) {
  const since = part.replaced ? `new since ${new Date(part.replaced).toLocaleDateString([], {dateStyle: "medium"})}` : "never reported as new";
  const used = [share(part.lamp_h.toFixed(1), part.lamp_h_limit, "h of light"), share(part.layers, part.layers_limit, "layers"), share(part.prints, part.prints_limit, "prints")].join(" \u00b7 ");
  const item = element("li", "", "", element("div", "what", "", element("div", "name", NAMES[part.part] || part.part), element("div", "more", used), element("div", "more", since)));
  if (part.reminder) item.firstChild.append(element("div", "error", part.reminder));
  item.append(only("print", button("Replaced", `The ${part.part} was replaced`, async () => {
    if (await confirmed(`Is the ${part.part} new? Its use counts from now on.`)) change("replaced", {part: part.part});
  })));
  return item;
}

function resinItem(resin) {
  const item = element("details", "", "", element("summary", "", resin.resin + (resin.is_default ? " (the printer's)" : "")));
  if (resin.trouble) {
    item.append(element("p", "error", resin.trouble));
    return item;
  }
  item.append(facts([
    ["Layer height", `${resin.layer_height_um} \u00b5m (${resin.layer_height_min_um} to ${resin.layer_height_max_um})`],
    ["Exposure", `${(resin.exposure_ms / 1000).toFixed(2)} s`],
    ["First layers", `${(resin.bottom_exposure_ms / 1000).toFixed(2)} s, ${resin.bottom_layers} layers`],
    ["Lift, with a second lift", `${resin.lift_mm} mm`],
    ["Print mode", resin.continuous ? "continuous" : "layered"],
  ]));
  item.append(element("h3", "", "Calibrations"));
  if (resin.calibrations.length === 0) item.append(element("p", "more", "None; contourctl fit makes them."));
  for (const calibration of resin.calibrations) {
    const values = calibration.values.map((value) => `${value.key.slice(1).replaceAll("/", " ").replaceAll("_", " ")}: ${value.before ?? "none"} \u2192 ${value.after ?? "none"}${value.uncertainty === null ? "" : ` \u00b1 ${value.uncertainty}`}`);
    item.append(element("p", "name", `${calibration.kind}, ${calibration.date}`), ...values.map((text) => element("p", "more", text)));
  }
  return item;
}

async function showCare() {
  try {
    const [vat, usage, profiles] = await Promise.all([get("/api/vat"), get("/api/usage"), resins()]);
    $("vat").textContent = vat.ml === null ? "The amount of resin in the vat is unknown." : `The vat holds ${vat.ml.toFixed(0)} ml.`;
    keepFocus(() => $("parts").replaceChildren(...usage.parts.map(partItem)), () => [document.querySelector("#care summary")]);
    $("usage").replaceChildren(facts([["Jobs", String(usage.jobs)], ["Layers", String(usage.layers)], ["Light", `${usage.lamp_h.toFixed(1)} h`], ["Resin", `${usage.resin_ml.toFixed(0)} ml`]]));
    $("resins").replaceChildren(...profiles.map(resinItem));
    if (usage.trouble) $("care-error").textContent = usage.trouble;
  } catch (error) {
    $("care-error").textContent = error.message;
  }
}

const filled = element("input");
Object.assign(filled, {type: "number", min: 0, max: 100000, step: "any", required: true, inputMode: "decimal"});
const submit = element("button", "", "Filled");
submit.type = "submit";
$("vat-form").append(field("Resin in the vat now, in ml", filled), submit);
$("vat-form").addEventListener("submit", (event) => {
  event.preventDefault();
  change("vat", {filled_ml: Number(filled.value)});
  filled.value = "";
});
$("care").addEventListener("toggle", () => { if ($("care").open) showCare(); });
