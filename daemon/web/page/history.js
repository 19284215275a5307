// The prints that have ended, the latest first.
import {$, button, duration, element, get, keepFocus, live} from "./base.js";

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
  if (job.layers > 0 && live.status && live.status.camera) item.append(button("Pictures", `Pictures of ${job.job}`, () => showPictures(item, job.job)));
  if (job.reason) item.firstChild.append(element("div", "more", job.reason));
  return item;
}

// Shows the time lapse and the pictures of a print below it, or hides them again.
async function showPictures(item, job) {
  if (item.shots) {
    item.shots.remove();
    item.shots = null;
    return;
  }
  const shots = item.shots = element("div", "shots"), told = element("p", "more"), of = `job=${encodeURIComponent(job)}`;
  told.setAttribute("role", "status");
  shots.append(told);
  item.append(shots);
  try {
    const {layers, time_lapse: film} = await get(`/api/pictures?${of}`);
    if (film) {
      const video = element("video");
      Object.assign(video, {controls: true, muted: true, playsInline: true, preload: "metadata", src: `/api/time_lapse?${of}`});
      video.setAttribute("aria-label", `Time lapse of ${job}`);
      shots.append(video);
    }
    if (layers.length) shots.append(...pictureOf(job, layers));
    else told.textContent = "No pictures were taken.";
  } catch (error) {
    told.textContent = error.message;
  }
}

// Returns one picture of a print, and a slider that chooses which one.
function pictureOf(job, layers) {
  const image = element("img"), slider = element("input"), text = element("p", "more");
  const show = () => {
    const layer = layers[slider.value];
    image.alt = text.textContent = `After layer ${layer}`;
    image.src = `/api/picture?job=${encodeURIComponent(job)}&layer=${layer}`;
  };
  Object.assign(slider, {type: "range", min: 0, max: layers.length - 1, step: 1});
  slider.value = layers.length - 1;
  slider.setAttribute("aria-label", `Picture of ${job}`);
  slider.addEventListener("input", () => { text.textContent = `After layer ${layers[slider.value]}`; });
  slider.addEventListener("change", show);
  show();
  return [image, slider, text];
}

async function showHistory(earlier) {
  try {
    const reply = await get(earlier ? `/api/history?before=${before}` : "/api/history");
    const items = reply.ended.reverse().map(historyItem);
    keepFocus(() => {
      if (earlier) $("history").append(...items);
      else $("history").replaceChildren(...items);
      before = reply.before;
      $("earlier").hidden = before === null;
    }, () => [$("history-title")]);
    $("history-empty").hidden = $("history").children.length > 0;
  } catch {
    shownFor = null;
  }
}
$("earlier").addEventListener("click", () => showHistory(true));
