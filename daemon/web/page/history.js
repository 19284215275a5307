// The prints that have ended, the latest first.
import {$, duration, element, get} from "./base.js";

let before = null, shownFor = null;

export function historyOf(status) {
  const key = JSON.stringify(status.last);
  if (key === shownFor) return;
  shownFor = key;
  showHistory(false);
}

export function forgetHistory() {
  shownFor = null;
}

function historyItem(job) {
  const ended = new Date(job.ended).toLocaleString([], {dateStyle: "medium", timeStyle: "short"});
  const more = [ended, job.layers_exposed ? `${job.layers_exposed} layers` : "", job.print_time_s ? duration(job.print_time_s) : "",
    job.resin_ml ? `${job.resin_ml.toFixed(1)} ml` : "", job.resin].filter(Boolean).join(" \u00b7 ");
  const item = element("li", "", "", element("div", "what", "", element("div", "name", job.job), element("div", "more", more)), element("span", job.outcome === "done" ? "faint" : "error", job.outcome));
  if (job.layers > 0) {
    const report = element("a", "", "Report");
    report.href = `/api/report?job=${encodeURIComponent(job.job)}`;
    report.setAttribute("aria-label", `Report of ${job.job}`);
    item.append(report);
  }
  if (job.reason) item.firstChild.append(element("div", "more", job.reason));
  return item;
}

async function showHistory(earlier) {
  try {
    const reply = await get(earlier ? `/api/history?before=${before}` : "/api/history");
    const items = reply.ended.reverse().map(historyItem);
    if (earlier) $("history").append(...items);
    else $("history").replaceChildren(...items);
    before = reply.before;
    $("earlier").hidden = before === null;
    $("history-empty").hidden = $("history").children.length > 0;
  } catch {
    shownFor = null;
  }
}
$("earlier").addEventListener("click", () => showHistory(true));
