#include "daemon/control/printer_status.hpp"

#include <algorithm>

#include "core/contract/expects.hpp"
#include "daemon/control/control_method.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/prepare/supports_text.hpp"
#include "daemon/report/time_causes.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {
namespace {

using Json = PrinterStatus::Json;

constexpr std::size_t kMaxQueued = 1'000, kMaxDetailed = 100, kMaxIncomplete = 10, kMaxWarnings = 10;

template <typename All, typename Take>
void for_first(const All& all, std::size_t most, const Take& take) {
  for (auto each = all.begin(); each != all.end() && most > 0; ++each, --most)
    take(*each);
}

std::size_t beyond(std::size_t all, std::size_t most) {
  return all > most ? all - most : 0;
}

std::string_view name_of(WaitingJob::Check check) {
  switch (check) {
    case WaitingJob::Check::Wanted:
      return "unchecked";
    case WaitingJob::Check::Running:
      return "checking";
    case WaitingJob::Check::Passed:
      return "ready";
    case WaitingJob::Check::Postponed:
      return "postponed";
    case WaitingJob::Check::Refused:
      return "leaving";
  }
  return "?";
}

Json interrupted_json(const InterruptedPrint& interrupted, double microsteps_per_mm) {
  const JobProgress& progress = interrupted.progress;
  const PrintProgress& print = progress.print;
  const auto millimetres = [](Nanometers height) { return to_millimeters(height).count(); };
  Json json{{"job", progress.job},
            {"layer", print.layer + 1},
            {"layers", progress.layers},
            {"phase", name_of(print.phase)},
            {"light_s", in_seconds(print.light)},
            {"exposure_s", in_seconds(print.exposure)}};
  json["least_height_mm"] = print.plate ? Json(millimetres(print.plate->least)) : Json();
  json["most_height_mm"] = print.plate ? Json(millimetres(print.plate->most)) : Json();
  const bool trustable = why_not_resumable(interrupted, false, true).empty();
  json["trust"] = trustable ? Json(describe_trust(progress, microsteps_per_mm)) : Json();
  return json;
}

Json ended_json(const EndedJob& job) {
  return {{"job", job.name}, {"outcome", job.outcome}, {"reason", job.reason}};
}

}  // namespace

Json PrinterStatus::queue(std::optional<std::size_t> number) const {
  const auto& waiting = parts_.queue.jobs();
  expects(!number || *number < waiting.size(), "there is a job of that number");
  Json jobs = Json::array();
  if (number) {
    jobs.push_back(waiting_job(*number));
  } else {
    for (std::size_t i = 0; i < std::min(waiting.size(), kMaxDetailed); ++i)
      jobs.push_back(waiting_job(i));
  }
  Json files = Json::array();
  for_first(waiting, kMaxQueued, [&](const WaitingJob& job) { files.push_back(job.file); });
  return Json{{"queue", files},
              {"more", beyond(waiting.size(), kMaxQueued)},
              {"jobs", jobs},
              {"arriving", parts_.spool.incoming().arriving(kMaxQueued)}};
}

std::string_view PrinterStatus::state_of(const WaitingJob& job) const {
  if (!job.asks.empty() && job.check == WaitingJob::Check::Passed) return "unaccepted";
  if (job.check != WaitingJob::Check::Passed || !parts_.queue.questions().wanted()) return name_of(job.check);
  return job.analyzed ? "ready" : "analyzing";
}

Json PrinterStatus::waiting_job(std::size_t number) const {
  const WaitingJob& waiting = parts_.queue.jobs()[number];
  Json job{{"number", number + 1},
           {"file", waiting.file},
           {"job", job_name_of(waiting.file)},
           {"state", state_of(waiting)},
           {"waiting_for", or_null(reason_to_wait(number))}};
  for (const char* key : {"bytes", "parts", "resin", "overrides", "layers", "thinnest_layer_um",
                          "thickest_layer_um", "height_mm", "print_time_s", "forecast", "supports"})
    job[key] = nullptr;
  job["resin_ml"] = waiting.analyzed ? or_null(waiting.analyzed->analysis.resin_ml) : Json();
  job["asks"] = waiting.asks;
  job["warnings"] = waiting.analyzed ? Json(waiting.analyzed->analysis.warnings) : Json::array();
  if (!waiting.outlook) return job;
  const JobOutlook& outlook = *waiting.outlook;
  job["bytes"] = outlook.bytes;
  job["parts"] = outlook.parts;
  job["resin"] = outlook.resin;
  job["overrides"] = overrides_json(outlook.overridden);
  job["layers"] = outlook.layers;
  job["thinnest_layer_um"] = to_millimeters(outlook.thinnest_layer).count() * 1000;
  job["thickest_layer_um"] = to_millimeters(outlook.thickest_layer).count() * 1000;
  job["height_mm"] = outlook.height_mm;
  job["print_time_s"] = in_seconds(outlook.forecast.time.total());
  job["forecast"] = forecast_json(outlook.forecast);
  if (outlook.supports) job["supports"] = supports_summary_json(*outlook.supports);
  return job;
}

// Returns the job's own reason to wait, or the queue's reason if the job is the next one; empty if there is
// none.
std::string PrinterStatus::reason_to_wait(std::size_t number) const {
  const WaitingJob& job = parts_.queue.jobs()[number];
  if (!job.trouble.empty()) return job.trouble;
  if (!job.postponed.empty()) return job.postponed;
  if (!job.asks.empty()) return question_about(job.file, job.asks);
  return number == parts_.queue.first() ? parts_.scheduler.waiting_for() : "";
}

PrinterMetrics PrinterStatus::metrics() const {
  const PrintMode& print = parts_.job.print();
  PrinterMetrics metrics{.printer = context_.config.name,
                         .state = state(),
                         .print = {},
                         .light_may_be_on = !dark(),
                         .ready = context_.machine.why_not_ready().empty(),
                         .held = parts_.hold.reason().has_value(),
                         .plate_occupied = parts_.hold.plate_occupant().has_value(),
                         .queued = parts_.queue.jobs().size(),
                         .ended = parts_.history.counts(),
                         .lit = parts_.job.lit(),
                         .late_steps = context_.machine.z_axis().late_steps().count};
  if (parts_.job.job() != nullptr && print.under_way()) {
    const JobSummary& summary = parts_.job.job()->prepared->summary;
    metrics.print = {print.layer() + 1, static_cast<std::int32_t>(summary.layers.count), print.time_left()};
  }
  return metrics;
}

Json PrinterStatus::status() const {
  Json status{{"printer", context_.config.name},
              {"spool", context_.config.spool_folder.string()},
              {"state", state()}};
  status["job"] = parts_.job.job() != nullptr ? job() : Json();
  status["queued"] = parts_.queue.jobs().size();
  add_incoming(status);
  add_reasons_to_wait(status);
  const auto& ended = parts_.history.jobs();
  status["reminders"] = parts_.reminders.due();
  status["last"] = ended.empty() ? Json() : ended_json(ended.back());
  status["dark"] = dark();
  status["manual"] = manual();
  status["camera"] = camera();
  return status;
}

std::string_view PrinterStatus::state() const {
  const CurrentJob& job = parts_.job;
  if (job.job() != nullptr && !job.print().under_way()) return job.finishing() ? "finishing" : "preparing";
  return job.print().state().name;
}

Json PrinterStatus::job() const {
  Json job{{"name", parts_.job.name()}};
  job["analysis"] = parts_.job.job()->analysis;
  const auto& prepared = parts_.job.job()->prepared;
  job["supports"] = prepared && prepared->summary.supports
                        ? supports_summary_json(counts_of(*prepared->summary.supports))
                        : Json();
  if (parts_.job.print().under_way()) add_print(job);
  return job;
}

void PrinterStatus::add_print(Json& job) const {
  const PrintMode& print = parts_.job.print();
  const JobSummary& summary = parts_.job.job()->prepared->summary;
  const PrintRecord& record = *parts_.job.job()->record;
  job["layer"] = print.layer() + 1;
  job["layers"] = summary.layers.count;
  job["layers_done"] = layers_exposed(record.layers());
  job["height_mm"] = to_millimeters(print.layer_top()).count();
  job["total_height_mm"] = summary.height_mm;
  job["layer_height_um"] = to_millimeters(print.layer_thickness()).count() * 1000;
  job["elapsed_s"] = in_seconds(record.elapsed());
  job["time_left_s"] = in_seconds(print.time_left());
  job["planned_s"] = causes_json(parts_.job.job()->forecast.time);
  job["took_s"] = causes_json(record.times());
  const std::optional<Duration> state_left = print.state_left();
  job["state_left_s"] = state_left ? Json(in_seconds(*state_left)) : Json();
  job["pause_pending"] = print.pause_pending();
  job["pause"] = print.pause_pending() ? Json(print.next_pause()) : Json();
  job["planned_pause"] = print.planned_pause() ? Json(describe(*print.planned_pause())) : Json();
  job["excluded"] = Json::array();
  for_first(record.exclusions(), kMaxDetailed,
            [&](const Exclusion& each) { job["excluded"].push_back(each.copy); });
  job["interruption"] = or_null(print.interruption());
  const std::vector<std::string>& warnings = parts_.job.job()->warnings;
  job["warnings"] = Json::array();
  for_first(warnings, kMaxWarnings, [&](const std::string& each) { job["warnings"].push_back(each); });
  job["warnings_more"] = beyond(warnings.size(), kMaxWarnings);
}

Json PrinterStatus::camera() const {
  if (!parts_.camera.exists()) return nullptr;
  const CameraFigures figures = parts_.camera.figures().value_or(CameraFigures());
  return {{"job", or_null(figures.job)},
          {"pictures", figures.pictures},
          {"last_layer", figures.last ? Json(*figures.last + 1) : Json()},
          {"failed", figures.failed},
          {"skipped", figures.skipped},
          {"trouble", or_null(figures.trouble)}};
}

bool PrinterStatus::dark() const {
  return !parts_.job.print().light_may_be_on() && !parts_.manual.light_may_be_on() &&
         context_.machine.projector().light_off_unconfirmed().empty();
}

Json PrinterStatus::manual() const {
  const ManualProcess& process = parts_.manual;
  const std::optional<Nanometers> height = context_.machine.z_axis().height();
  const std::optional<Nanometers> shift = process.homing_shift();
  Json manual{
      {"state", name_of(process.state())},
      {"operations", process.operations()},
      {"problem", or_null(process.problem())},
      {"dark", !process.light_may_be_on() && context_.machine.projector().light_off_unconfirmed().empty()},
      {"height_mm", height ? Json(to_millimeters(*height).count()) : Json()},
      {"homing_shift_um", shift ? Json(to_millimeters(*shift).count() * 1000) : Json()},
      {"picture", or_null(process.picture())},
      {"projector", Json()}};
  if (const std::optional<ProjectorStatus>& projector = process.projector()) {
    manual["projector"] = {{"powered", or_null(projector->powered)},
                           {"lamp_hours", or_null(projector->lamp_hours)}};
  }
  return manual;
}

void PrinterStatus::add_incoming(Json& status) const {
  const auto add = [&status](const std::string& key, Json first, std::size_t all) {
    status[key] = std::move(first);
    status[key + "_more"] = beyond(all, kMaxIncomplete);
  };
  const auto& incoming = parts_.spool.incoming();
  Json incomplete = Json::object(), postponed = Json::object(), unaccepted = Json::object(),
       ignored = Json::object(), deletable = Json::array();
  for_first(incoming.incomplete(), kMaxIncomplete,
            [&](const auto& plate) { incomplete[plate.first] = plate.second; });
  std::size_t all_postponed = 0, all_unaccepted = 0;
  for (const WaitingJob& job : parts_.queue.jobs()) {
    if (!job.postponed.empty() && ++all_postponed <= kMaxIncomplete) postponed[job.file] = job.postponed;
    if (!job.asks.empty() && ++all_unaccepted <= kMaxIncomplete)
      unaccepted[job.file] = question_about(job.file, job.asks);
  }
  for_first(incoming.ignored(), kMaxIncomplete,
            [&](const auto& each) { ignored[each.first] = sentence_for(each.second); });
  for_first(incoming.originals(), kMaxIncomplete,
            [&](const std::string& file) { deletable.push_back(file); });
  add("incomplete", std::move(incomplete), incoming.incomplete().size());
  add("postponed", std::move(postponed), all_postponed);
  add("unaccepted", std::move(unaccepted), all_unaccepted);
  add("ignored", std::move(ignored), incoming.ignored().size());
  add("deletable", std::move(deletable), incoming.originals().size());
}

void PrinterStatus::add_reasons_to_wait(Json& status) const {
  const QueueHold& hold = parts_.hold;
  status["plate"] = hold.plate_occupant() ? "occupied" : "clear";
  status["plate_job"] = or_null(hold.plate_occupant());
  status["not_ready_reason"] = or_null(context_.machine.why_not_ready());
  status["held"] = or_null(hold.sentence());
  status["interrupted"] =
      hold.interrupted()
          ? interrupted_json(*hold.interrupted(), context_.config.simulated.axis.microsteps_per_mm)
          : Json();
  status["waiting_for"] = or_null(parts_.scheduler.waiting_for());
}

}  // namespace contourd
