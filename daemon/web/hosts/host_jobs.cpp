#include "daemon/web/hosts/host_jobs.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "daemon/formats/model_names.hpp"
#include "daemon/web/hosts/host_replies.hpp"

namespace contourd::web {
namespace {

using Json = ControlLink::Json;

// Return a value of an object; 0, false or an empty one if there is none.
double number_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : 0;
}

std::int64_t count_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

bool is_true(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_boolean() && found->get<bool>();
}

Json object_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? *found : Json::object();
}

std::vector<std::string> texts_in(const Json& object, const char* key) {
  std::vector<std::string> texts;
  if (const auto found = object.find(key); found != object.end() && found->is_array())
    for (const Json& text : *found)
      if (text.is_string()) texts.push_back(text);
  return texts;
}

HostJob waiting_job(const Json& job) {
  return {.name = json_text(job, "job"),
          .file = json_text(job, "file"),
          .state = json_text(job, "state"),
          .waiting_for = json_text(job, "waiting_for"),
          .resin = json_text(job, "resin"),
          .bytes = count_of(job, "bytes"),
          .layers = count_of(job, "layers"),
          .layer_um = number_of(job, "thickest_layer_um"),
          .print_time_s = number_of(job, "print_time_s"),
          .resin_ml = number_of(job, "resin_ml"),
          .asks = texts_in(job, "asks"),
          .warnings = texts_in(job, "warnings")};
}

HostPhase phase_of(std::string_view state, bool pause_pending) {
  constexpr std::array kStates{
      std::pair{"idle", HostPhase::Idle},           std::pair{"preparing", HostPhase::Starting},
      std::pair{"warming up", HostPhase::Starting}, std::pair{"homing", HostPhase::Starting},
      std::pair{"braking", HostPhase::Pausing},     std::pair{"raising", HostPhase::Pausing},
      std::pair{"paused", HostPhase::Paused},       std::pair{"held", HostPhase::Paused},
      std::pair{"halting", HostPhase::Cancelling},  std::pair{"parking", HostPhase::Starting},
      std::pair{"ending", HostPhase::Starting},     std::pair{"finishing", HostPhase::Starting}};
  const auto* const found = std::ranges::find(kStates, state, [](const auto& each) { return each.first; });
  if (found != kStates.end()) return found->second;
  return pause_pending ? HostPhase::Pausing : HostPhase::Printing;
}

// Returns why the printer waits, or how the last job failed; empty if neither.
std::string reason_of(const Json& status, const Json& job) {
  for (std::string reason :
       {json_text(job, "interruption"), json_text(job, "pause"), json_text(status, "held"),
        json_text(status, "not_ready_reason"), json_text(status, "waiting_for")})
    if (!reason.empty()) return reason;
  const Json last = object_of(status, "last");
  if (!job.empty() || json_text(last, "outcome") != "failed") return "";
  return json_text(last, "job") + " failed: " + json_text(last, "reason");
}

}  // namespace

std::uint32_t id_of(std::string_view name) {
  // FNV-1a, 32 bits.
  std::uint32_t hash = 2166136261U;
  for (const char letter : name)
    hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619U;
  return std::max(hash & 0x7FFFFFFFU, 1U);
}

bool HostJob::is_file(const std::string& other) const {
  return other == file || (is_printing && model_stem(other) == name);
}

std::optional<HostJob> host_print(const Json& status) {
  const Json job = object_of(status, "job");
  if (job.empty()) return std::nullopt;
  const std::string name = json_text(job, "name");
  HostJob print{.name = name, .file = name, .is_printing = true, .state = json_text(status, "state")};
  print.layers = count_of(job, "layers");
  print.layer_um = number_of(job, "layer_height_um");
  print.print_time_s = number_of(job, "elapsed_s") + number_of(job, "time_left_s");
  print.resin_ml = number_of(object_of(job, "analysis"), "resin_ml");
  return print;
}

std::vector<HostJob> host_jobs(const Json& status, const Json& queue) {
  std::vector<HostJob> jobs;
  if (std::optional<HostJob> print = host_print(status)) jobs.push_back(std::move(*print));
  if (const auto found = queue.find("jobs"); found != queue.end() && found->is_array())
    for (const Json& job : *found)
      if (job.is_object() && json_text(job, "state") != "leaving") jobs.push_back(waiting_job(job));
  return jobs;
}

HostStatus HostStatusReader::read(const Json& status) {
  const Json job = object_of(status, "job");
  const std::string state = json_text(status, "state"), reason = reason_of(status, job);
  HostStatus read{.printer = json_text(status, "printer"), .text = reason.empty() ? state : reason};
  read.job = host_print(status);
  read.is_lit = status.contains("dark") && !is_true(status, "dark");
  if (!read.job) {
    const Json manual = object_of(status, "manual"), last = object_of(status, "last");
    if (manual.contains("height_mm") && !manual["height_mm"].is_null())
      read.height_mm = number_of(manual, "height_mm");
    if (!job_.empty() && json_text(last, "job") == job_) read.layers = layers_;
    if (read.layers > 0 && json_text(last, "outcome") == "done") read.layer = read.layers;
    cancelled_.clear();
    printed_.reset();
    return read;
  }
  if (std::exchange(job_, read.job->name) != job_) {
    layers_ = 0;
    printed_.reset();
  }
  read.phase = job_ == cancelled_ ? HostPhase::Cancelling : phase_of(state, is_true(job, "pause_pending"));
  if (job.contains("layer")) {
    read.layer = count_of(job, "layer");
    read.layers = layers_ = read.job->layers;
    read.height_mm = number_of(job, "height_mm");
    read.time_left_s = number_of(job, "time_left_s");
    printed_ = read;
  } else if (printed_) {  // its files are being filed
    read.job = printed_->job;
    read.layer = printed_->layer;
    read.layers = printed_->layers;
    read.height_mm = printed_->height_mm;
  }
  return read;
}

}  // namespace contourd::web
