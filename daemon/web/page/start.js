// The start of the page: login, and the events by which the server sends each status.
import {$, live, send, session, setText} from "./base.js";
import "./care.js";
import {forgetHistory, historyOf} from "./history.js";
import {showNow, showUnknown} from "./print.js";
import {forgetQueue, queueOf} from "./queue.js";
import {showManual} from "./service.js";
import {uploadNext} from "./upload.js";

// The server sends a beat every 5 s. A connection without any for this time is dead, and the light may have changed since.
const SILENT_MS = 12000, RETRY_MS = 3000, PATIENCE_MS = 10000;
const LOST = "The connection to the printer is lost. Trying again.";
let events = null, heardAt = 0, retry = null;

function close() {
  if (events) events.close();
  events = null;
  clearTimeout(retry);
}

function showLogin() {
  close();
  showUnknown();
  $("page").hidden = $("logout").hidden = true;
  $("login").hidden = false;
  $("password").focus();
}
session.ended = showLogin;

$("login-form").addEventListener("submit", async (event) => {
  event.preventDefault();
  $("login-error").textContent = "";
  try {
    await send("/api/login", {method: "POST", body: JSON.stringify({password: $("password").value})});
    $("password").value = "";
    start();
  } catch (error) {
    $("login-error").textContent = error.message;
    $("password").select();
  }
});

$("logout").addEventListener("click", async () => {
  await send("/api/logout", {method: "POST"}).catch(() => {});
  showLogin();
});

function open() {
  close();
  heardAt = performance.now();
  events = new EventSource("/api/events");
  events.onmessage = (event) => show(JSON.parse(event.data));
  events.addEventListener("beat", () => { heardAt = performance.now(); });
  events.onerror = explain;
}

// Shows why there are no events. Scripts cannot read the reply of an EventSource, so the page asks once more.
async function explain() {
  lose($("connection").textContent || LOST);
  const stop = new AbortController(), reply = await ask("/api/events", stop);
  if (reply && reply.status === 401) showLogin();
  else if (!events) showConnection(reply && !reply.ok ? await reply.text() : LOST);
  stop.abort();
}

// Returns the reply; null if there is none in time.
async function ask(path, stop = new AbortController()) {
  const timeout = setTimeout(() => stop.abort(), PATIENCE_MS);
  const reply = await fetch(path, {signal: stop.signal}).catch(() => null);
  clearTimeout(timeout);
  return reply;
}

function lose(text) {
  close();
  showUnknown();
  showConnection(text);
  retry = setTimeout(start, RETRY_MS);
}

function showConnection(text) {
  $("connection").hidden = !text;
  setText("connection", text);
}

function show(now) {
  heardAt = performance.now();
  if (now.unreachable) {
    showUnknown();
    showConnection(now.unreachable.includes("contourd") ? now.unreachable : `contourd does not answer: ${now.unreachable}`);
    return;
  }
  showConnection("");
  live.status = now;
  live.receivedAt = performance.now();
  showNow();
  showManual();
  queueOf(now);
  historyOf(now);
}

// Opens the page, or the login. A page that no one sees has no events: browsers open six connections to a server at most, for all tabs.
async function start() {
  close();
  if (document.hidden) return;
  const reply = await ask("/api/session");
  if (reply && reply.status === 401) return showLogin();
  if (reply && reply.ok) {
    session.role = (await reply.json()).role;
    document.body.dataset.role = session.role;
  }
  const opens = $("page").hidden, byHand = $("login").contains(document.activeElement);
  $("login").hidden = true;
  $("page").hidden = $("logout").hidden = false;
  if (byHand) $("printer").focus();
  if (!reply || !reply.ok) return lose(reply ? await reply.text() : LOST);
  if (document.hidden) return;
  forgetQueue();
  if (opens) forgetHistory();
  open();
  uploadNext();
}

document.addEventListener("visibilitychange", () => {
  if (!document.hidden) return $("login").hidden ? start() : undefined;
  close();
  showUnknown();
});
setInterval(() => { if (events && performance.now() - heardAt > SILENT_MS) lose(LOST); }, 1000);
start();
