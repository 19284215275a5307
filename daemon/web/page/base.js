// Shared parts of the page: elements, requests to the server, texts, and questions to the user.

export const $ = (id) => document.getElementById(id);

// The last status of the printer, and when it came; null before the first one.
export const live = {status: null, receivedAt: 0};

// The role of the user, and what is called when the server wants the user to log in.
export const session = {role: "print", ended: () => {}};

// Makes an element with a class, text and children. Texts of strangers never become markup.
export function element(tag, className, text, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

// Marks an element as one for users who may print, or who may do service; others do not see it.
export function only(role, made) {
  made.classList.add(`for-${role}`);
  return made;
}

export function button(text, label, action, className = "quiet") {
  const made = element("button", className, text);
  made.type = "button";
  if (label !== text) made.setAttribute("aria-label", label);
  made.addEventListener("click", action);
  return made;
}

// Sets a text if it differs, so that screen readers are not told again.
export function setText(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

// Changes elements. If the focus would be lost, because its element moves, goes or is hidden, it returns there, or goes
// to an element of the same label, or to the first of others() that is shown.
export function keepFocus(change, others) {
  const held = document.activeElement, label = held && held.getAttribute("aria-label");
  change();
  if (!held || held === document.body || (document.activeElement !== held && document.activeElement !== document.body)) return;
  const same = label && document.querySelector(`[aria-label="${CSS.escape(label)}"]`);
  const next = [held, same, ...others(held)].find((each) => each && each.checkVisibility());
  if (next && next !== document.activeElement) next.focus();
}

// Sends a request; throws an Error with the server's sentence if it is refused.
export async function send(path, options) {
  let reply;
  try {
    reply = await fetch(path, options);
  } catch {
    throw new Error("the printer cannot be reached");
  }
  if (reply.status === 401 && path !== "/api/login") {
    session.ended();
    throw new Error("the session had ended: try again");
  }
  if (!reply.ok) throw new Error((await reply.text()).trim() || `the printer answers ${reply.status}`);
  return reply;
}
export const get = async (path) => (await send(path)).json();
export const call = async (method, parameters = {}) => (await send(`/api/call/${method}`, {method: "POST", body: JSON.stringify(parameters)})).json();

export function duration(seconds) {
  const whole = Math.max(0, Math.round(seconds)), minutes = Math.floor(whole / 60);
  if (minutes >= 60) return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
  return minutes > 0 ? `${minutes} min ${String(whole % 60).padStart(2, "0")} s` : `${whole} s`;
}

// Returns a sentence of contourd without the commands of a shell that it advises: the page has buttons and fields for them.
export const withoutCommand = (text) => text.replace(/set "unit": "(\w+)" in its ticket/g, "choose $1 as the unit under Details")
  .replace(/ \(contourctl [^)]*\)/g, "").replace(/[;,]? ?(run|:)? ?"contourctl [^"]*"( to [^;]*)?/g, "");

// Returns a list of terms and descriptions, without those that have no text.
export function facts(pairs) {
  const list = element("dl", "facts");
  for (const [term, text] of pairs) if (text) list.append(element("div", "", "", element("dt", "", term), element("dd", "", text)));
  return list;
}

let answered = Promise.resolve();
// Asks a question, once the one before is answered: its "close" event comes later than its answer. Resolves to true if
// the answer is yes.
export function confirmed(question) {
  answered = answered.then(() => new Promise((resolve) => {
    $("question").textContent = question;
    $("confirm").returnValue = "no";
    $("confirm").showModal();
    $("confirm").addEventListener("close", () => resolve($("confirm").returnValue === "yes"), {once: true});
  }));
  return answered;
}

let fields = 0;
// Makes a labelled input or select, in a box of its own.
export function field(label, input, hint = "") {
  input.id = `field-${++fields}`;
  const named = element("label", "", label);
  named.htmlFor = input.id;
  const box = element("div", "field", "", named, input);
  if (hint) {
    const text = element("p", "more", hint);
    text.id = `${input.id}-hint`;
    input.setAttribute("aria-describedby", text.id);
    box.append(text);
  }
  return box;
}

// Makes a select of [value, text] pairs.
export function choice(pairs, chosen) {
  const made = element("select");
  for (const [value, text] of pairs) {
    const option = element("option", "", text);
    option.value = value;
    made.append(option);
  }
  made.value = chosen;
  return made;
}
