// Uploads: one file after the other, by the button or by dropping them onto the page.
import {$, button, element, keepFocus, session} from "./base.js";
import {openJob, refreshQueue} from "./queue.js";

const waiting = [];
let uploading = false;

// A device on which models are to print at once remembers it.
const stored = () => { try { return localStorage.getItem("print-at-once"); } catch { return null; } };
$("ask-first").checked = stored() !== "yes";
$("ask-first").addEventListener("change", () => {
  try {
    localStorage.setItem("print-at-once", $("ask-first").checked ? "no" : "yes");
  } catch {
    // Without storage, the box is checked again next time.
  }
});

function add(files) {
  for (const file of files) {
    const bar = element("progress"), text = element("div", "more", "waits");
    bar.max = 1;
    bar.value = 0;
    bar.setAttribute("aria-label", `Upload of ${file.name}`);
    const item = element("li", "", "", element("div", "what", "", element("div", "name", file.name), bar, text));
    $("uploads").append(item);
    waiting.push({file, bar, text, item, confirm: $("ask-first").checked});
  }
  uploadNext();
}

// Uploads the next file, unless one is being uploaded. After the end of the session, files wait for the next login.
export function uploadNext() {
  if (uploading || waiting.length === 0) return;
  uploading = true;
  const next = waiting.shift(), {file, bar, text, item, confirm} = next, request = new XMLHttpRequest();
  const ended = (sentence) => {
    uploading = false;
    bar.remove();
    text.textContent = sentence;
    if (sentence) {
      text.className = "error";
      text.setAttribute("role", "alert");
      item.append(button("\u2715", `Close the message on ${file.name}`, () => keepFocus(() => item.remove(), () => [$("files"), $("queue-title")])));
    } else {
      item.remove();
    }
    refreshQueue();
    uploadNext();
  };
  const sessionEnded = () => {
    uploading = false;
    waiting.unshift(next);
    bar.value = 0;
    text.textContent = "waits for the login";
    session.ended();
  };
  request.open("POST", `/api/upload?name=${encodeURIComponent(file.name)}${confirm ? "&confirm=1" : ""}`);
  request.upload.onprogress = (event) => {
    bar.value = event.total ? event.loaded / event.total : 0;
    text.textContent = `${Math.round(100 * bar.value)} % of ${(event.total / 1048576).toFixed(1)} MiB`;
  };
  request.onload = () => {
    if (request.status === 401) return sessionEnded();
    if (request.status === 201 && confirm) openJob(JSON.parse(request.responseText).job);
    ended(request.status === 201 ? "" : request.responseText.trim() || `the printer answers ${request.status}`);
  };
  // A server that refuses a large file may close the connection before the browser has read why.
  request.onerror = async () => {
    const reply = await fetch("/api/session").catch(() => null);
    if (reply && reply.status === 401) return sessionEnded();
    ended(`${file.name} did not arrive: the connection was lost`);
  };
  request.send(file);
}

$("files").addEventListener("change", () => {
  add($("files").files);
  $("files").value = "";
});
for (const [name, over] of [["dragover", true], ["dragleave", false], ["drop", false]])
  document.addEventListener(name, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", over && !$("page").hidden && session.role !== "watch");
    if (name === "drop" && !$("page").hidden && session.role !== "watch") add(event.dataTransfer.files);
  });
