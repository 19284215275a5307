#include "daemon/history/job_history.hpp"

#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {

JobEnd job_end(const EndedJob& job) {
  return {.key = job.key, .job = job.name, .outcome = job.outcome, .reason = job.reason, .ended = job.ended};
}

EndedJob ended_job(const JobEnd& end) {
  return {.name = end.job,
          .outcome = end.outcome,
          .reason = end.reason,
          .began = end.ended,
          .ended = end.ended,
          .key = end.key};
}

nlohmann::ordered_json history_json(const EndedJob& job) {
  const JobFigures& figures = job.figures;
  return {{"job", job.name},
          {"outcome", job.outcome},
          {"reason", job.reason},
          {"began", iso_time(job.began)},
          {"ended", iso_time(job.ended)},
          {"resin", figures.resin},
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
          {"warnings", figures.warnings},
          {"analysis", job.analysis}};
}

void JobHistory::add(EndedJob job) {
  ++counts_[job.outcome];
  ++total_;
  jobs_.push_back(std::move(job));
  if (jobs_.size() > kLongest) jobs_.pop_front();
}

}  // namespace contourd
