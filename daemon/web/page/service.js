// Service at the machine: homing, stopping, light off, a look at the switches and the log, and a diagnosis.
import {$, call, confirmed, element, get, live, setText} from "./base.js";

export function showManual() {
  const {manual} = live.status;
  setText("manual", `By hand: ${manual.state}.`);
  setText("plate-height", manual.height_mm === null ? "The plate's height is unknown." : `The plate is at ${manual.height_mm.toFixed(2)} mm.`);
}

async function act(action) {
  $("service-error").textContent = "";
  try {
    await action();
  } catch (error) {
    $("service-error").textContent = error.message;
  }
}

$("home").addEventListener("click", async () => {
  if (await confirmed("Is nothing in the way of the plate? It moves to its limit switch.")) act(() => call("home"));
});
$("stop").addEventListener("click", () => act(() => call("stop")));
$("light-off").addEventListener("click", () => act(() => call("light_off")));
// The latest entries of contourd's log, the newest first.
$("show-log").addEventListener("click", () => act(async () => {
  const {entries} = await get("/api/log");
  $("log").replaceChildren(...entries.reverse().map((each) => element("li", "", "",
    element("div", "what", "", element("div", each.level === "error" ? "error" : "", each.message), element("div", "more", `${new Date(each.time).toLocaleString()} \u00b7 ${each.level}`)))));
}));
$("look").addEventListener("click", () => act(async () => {
  const {inputs} = await get("/api/inputs");
  const texts = inputs.map((each) => [each.name, each.active === null ? "cannot be read" : each.active ? "active" : "not active"]);
  $("inputs").replaceChildren(...(texts.length ? texts : [["No inputs", ""]]).map(([name, text]) => element("li", "", "", element("span", "what", name), element("span", "faint", text))));
}));
// Saves what the printer says of itself as a file, for a bug report.
$("diagnose").addEventListener("click", () => act(async () => {
  const said = {saved: new Date().toISOString()};
  for (const what of ["status", "queue", "history", "inputs", "log", "usage", "vat", "resins", "settings"]) {
    try {
      said[what] = await get(`/api/${what}`);
    } catch (error) {
      said[what] = {refused: error.message};
    }
  }
  const link = element("a");
  link.href = URL.createObjectURL(new Blob([JSON.stringify(said, null, 1)], {type: "application/json"}));
  link.download = `contourd-diagnosis-${said.saved.slice(0, 19).replace(/:/g, "-")}.json`;
  link.click();
  URL.revokeObjectURL(link.href);
}));
