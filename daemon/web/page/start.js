// The start of the page: login, and the events by which the server sends each status.
import {$, live, send, session} from "./base.js";
import "./care.js";
import {forgetHistory, historyOf} from "./history.js";
import {showNow} from "./print.js";
import {forgetQueue, queueOf} from "./queue.js";
import {showManual} from "./service.js";
import "./upload.js";

let events = null;

function showLogin() {
  if (events) events.close();
  events = null;
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
  $("login").hidden = true;
  $("page").hidden = $("logout").hidden = false;
  forgetQueue();
  forgetHistory();
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
  live.status = now;
  live.receivedAt = performance.now();
  showNow();
  showManual();
  queueOf(now);
  historyOf(now);
}

async function start() {
  if (events) events.close();
  events = null;
  const reply = await fetch("/api/session").catch(() => null);
  if (reply && reply.status === 401) return showLogin();
  if (reply && reply.ok) {
    session.role = (await reply.json()).role;
    document.body.dataset.role = session.role;
  }
  open();
}
start();
