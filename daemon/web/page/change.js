// Changes of the print under way: its settings, a planned pause, and copies that are left out.
import {$, button, call, confirmed, element, field, get, keepFocus, live} from "./base.js";

// The settings that can be changed, as contourd names them, with their labels; those of rises are for a plate that rises in the light.
const SETTINGS = [["exposure", "Exposure in %", 0.1], ["lift", "Lift in mm, without a second lift", 0.1], ["lift-speed", "Lift speed in mm/s", 0.1], ["rest", "Rest after the light in ms", 10],
  ["speed", "Rise: speed in mm/h", 1], ["light", "Rise: light in %", 0.1]];
let job = null, excludedFor = null, settingsFor = null, settingsAt = 0;

// Makes a form of one number, whose refusal is shown beside it. `act` gets the number.
function numberForm(label, step, text, act) {
  const input = element("input"), box = field(label, input), bounds = element("p", "more"), submit = element("button", "", text), told = element("p", "error"), form = element("form", "change", "", box, submit, bounds, told);
  Object.assign(input, {type: "number", step: "any", min: 0, required: true});
  input.inputMode = step % 1 ? "decimal" : "numeric";
  submit.type = "submit";
  submit.setAttribute("aria-label", `${text}: ${label}`);
  told.setAttribute("role", "alert");
  told.id = `${input.id}-told`;
  bounds.id = `${input.id}-bounds`;
  input.setAttribute("aria-describedby", `${bounds.id} ${told.id}`);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    told.textContent = "";
    told.className = "error";
    try {
      await act(Number(input.value));
      told.className = "more";
      told.textContent = `${input.value} applies from ${label.startsWith("Rise: ") ? "now" : "the next layer"} on.`;
      input.value = "";
      showSettings();
    } catch (error) {
      told.textContent = error.message;
    }
  });
  Object.assign(form, {told, bounds, input});
  return form;
}

// Returns a number with up to five digits, as a person writes it.
const figure = (value) => String(Number(value.toPrecision(5)));

// Shows the values in force and their bounds, which contourd knows. A print has only some of the settings.
async function showSettings() {
  const reply = await get("/api/settings").catch(() => null);
  if (!reply) return;
  forms.forEach((form, number) => {
    const setting = reply.settings.find((each) => each.setting === SETTINGS[number][0]);
    form.hidden = !setting;
    if (!setting) return;
    form.input.placeholder = figure(setting.value);
    form.bounds.textContent = `Now ${figure(setting.value)} ${setting.unit}; ${setting.fixed || `${figure(setting.least)} to ${figure(setting.most)} ${setting.unit}`}`.trim() + ".";
    form.input.disabled = form.querySelector("button").disabled = setting.fixed !== null;
  });
}

const forms = SETTINGS.map(([setting, label, step]) => numberForm(label, step, "Set", (value) => call("set", {setting, value})));
const pauseForm = numberForm("Pause before layer", 1, "Plan", async (at_layer) => {
  await call("pause", {at_layer});
  setTimeout(() => { pauseForm.told.textContent = ""; });
});
$("change-fields").append(...forms, pauseForm);

$("no-pause").addEventListener("click", async () => {
  $("change-error").textContent = "";
  try {
    await call("resume");
  } catch (error) {
    $("change-error").textContent = error.message;
  }
});

// Shows the planned pause and the copies of the print; `prints` is false without a print.
export function showChanges(prints) {
  $("change").hidden = !prints;
  if (!prints) {
    job = null;
    $("change").open = false;
    return;
  }
  const now = live.status.job, excluded = JSON.stringify(now.excluded);
  $("planned").hidden = !now.planned_pause;
  $("planned-text").textContent = now.planned_pause ? `The print pauses ${now.planned_pause}. ` : "";
  if (now.name !== job) for (const form of [...forms, pauseForm]) form.told.textContent = "";
  // The bounds of the exposure differ between the first layers and the others.
  const settings = `${now.name} ${now.layer} ${live.status.state === "parking"}`;
  if (settings !== settingsFor && $("change").open && performance.now() - settingsAt > 1000) {
    settingsFor = settings;
    settingsAt = performance.now();
    showSettings();
  }
  if ((now.name !== job || excluded !== excludedFor) && $("change").open) showCopies();
  job = now.name;
  excludedFor = excluded;
}

$("change").addEventListener("toggle", () => {
  if (!$("change").open) return;
  showCopies();
  showSettings();
});

async function showCopies() {
  try {
    const plate = await get("/api/copies");
    $("copies-box").hidden = plate.copies.length < 2;
    if (plate.copies.length < 2) return;
    const more = plate.more > 0 ? [element("li", "more", `and ${plate.more} more`)] : [];
    keepFocus(() => $("copies").replaceChildren(...plate.copies.map(copyItem), ...more), () => [document.querySelector("#change summary")]);
  } catch {
    $("copies-box").hidden = true;
  }
}

function copyItem(copy) {
  // Adding 0 makes -0 a 0 without a sign.
  const rounded = (mm) => (Math.round(mm * 10) / 10 + 0).toFixed(1);
  const place = `${copy.position_mm.map(rounded).join(", ")} mm from the middle`;
  const item = element("li", "", "", element("div", "what", "", element("div", "name", copy.name), element("div", "more", place)));
  if (copy.excluded_from !== null) {
    item.append(element("span", "faint", `left out from layer ${copy.excluded_from}`));
    return item;
  }
  item.append(button("Leave out", `Leave out ${copy.name}`, async () => {
    if (!await confirmed(`Leave ${copy.name} dark from the next layer on? This cannot be undone.`)) return;
    $("change-error").textContent = "";
    try {
      await call("exclude", {copy: String(copy.number)});
      showCopies();
    } catch (error) {
      $("change-error").textContent = error.message;
    }
  }));
  return item;
}
