#include "daemon/history/job_history.hpp"

#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {

namespace {

using Json = nlohmann::ordered_json;

// Maximum size of the figures in the record, in bytes; longer ones lose their texts.
constexpr std::size_t kLongestFigures = 4'000;

Json figures_json(const JobFigures& figures) {
  return {{"resin", figures.resin},
          {"settings", figures.settings},
          {"height_mm", figures.height_mm},
          {"layer_height_um", figures.layer_height_um},
          {"layers", figures.layers},
          {"layers_exposed", figures.layers_exposed},
          {"print_time_s", figures.print_time_s},
          {"lit_s", figures.lit_s},
          {"light_asked_s", figures.light_asked_s},
          {"most_light_over_ms", figures.most_light_over_ms},
          {"resin_ml", figures.resin_ml},
          {"interruptions", figures.interruptions},
          {"late_steps", figures.late_steps},
          {"warnings", figures.warnings}};
}

// Returns the figures as a text for the record; empty for a job that was not printed.
std::string recorded_figures(JobFigures figures) {
  if (figures.layers == 0) return "";
  const auto text = [&figures] {
    return figures_json(figures).dump(-1, ' ', true, Json::error_handler_t::replace);
  };
  if (text().size() > kLongestFigures) {
    figures.settings.clear();
    figures.warnings = {"the warnings of this print are in its report"};
  }
  return text();
}

// Returns the figures in a text of the record; no figures if contourd did not write the text.
JobFigures figures_in(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return {};
  try {
    return {.resin = json.at("resin"),
            .settings = json.at("settings"),
            .warnings = json.at("warnings"),
            .height_mm = json.at("height_mm"),
            .layer_height_um = json.at("layer_height_um"),
            .layers = json.at("layers"),
            .layers_exposed = json.at("layers_exposed"),
            .print_time_s = json.at("print_time_s"),
            .lit_s = json.at("lit_s"),
            .light_asked_s = json.at("light_asked_s"),
            .most_light_over_ms = json.at("most_light_over_ms"),
            .resin_ml = json.at("resin_ml"),
            .interruptions = json.at("interruptions"),
            .late_steps = json.at("late_steps")};
  } catch (const Json::exception&) {
    return {};
  }
}

}  // namespace

JobEnd job_end(const EndedJob& job) {
  return {.key = job.key,
          .job = job.name,
          .outcome = job.outcome,
          .reason = job.reason,
          .ended = job.ended,
          .figures = recorded_figures(job.figures)};
}

EndedJob ended_job(const JobEnd& end) {
  return {.name = end.job,
          .outcome = end.outcome,
          .reason = end.reason,
          .figures = figures_in(end.figures),
          .began = end.ended,
          .ended = end.ended,
          .key = end.key};
}

nlohmann::ordered_json history_json(const EndedJob& job) {
  Json json{{"job", job.name},
            {"outcome", job.outcome},
            {"reason", job.reason},
            {"began", iso_time(job.began)},
            {"ended", iso_time(job.ended)}};
  json.update(figures_json(job.figures));
  json["analysis"] = job.analysis;
  return json;
}

void JobHistory::add(EndedJob job) {
  ++counts_[job.outcome];
  ++total_;
  jobs_.push_back(std::move(job));
  if (jobs_.size() > kLongest) jobs_.pop_front();
}

}  // namespace contourd
