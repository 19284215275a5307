#include "daemon/ctl/watch/progress_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "daemon/ctl/terminal/client.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = ProgressLines::Json;

constexpr std::size_t kBar = 30;

double part_done(const Json& job) {
  return std::clamp(job.value("layers_done", 0) / std::fmax(job.value("layers", 1), 1), 0.0, 1.0);
}

std::string line_of(const Json& job, const std::string& state) {
  const double part = part_done(job);
  std::string bar(kBar, '.');
  std::fill_n(bar.begin(), static_cast<std::size_t>(part * static_cast<double>(bar.size())), '#');
  const std::string interruption = text_of(job, "interruption");
  return fmt::format("{} [{}] {:3.0f} %  layer {}/{}  {:.2f} mm  {} left  {}{}", text_of(job, "name"), bar,
                     std::floor(part * 100), job.value("layer", 0), job.value("layers", 0),
                     job.value("height_mm", 0.0), time_left(job), state,
                     interruption.empty() ? "" : ", " + interruption);
}

// True for states that do not occur in every layer.
bool is_worth_a_line(const std::string& state) {
  return state == "warming up" || state == "homing" || state == "paused" || state == "held" ||
         state == "parking";
}

// Returns the findings that the user has to accept for this job, or an empty text.
std::string question_of(const Json& status, const std::string& job) {
  for (const auto& [file, question] : status["unaccepted"].items())
    if (job_name_of(file) == job) return printable(question.get<std::string>());
  return "";
}

}  // namespace

void ProgressLines::show(const Json& status, const std::string& job, bool is_under_way) {
  if (job.empty() || is_under_way) return show_job(status);
  std::string text = printable(job) + ": waits";
  if (const std::string question = question_of(status, job); !question.empty()) {
    text += ": " + question;
  } else if (status["job"].is_object()) {
    text += fmt::format(" while {} is printed", text_of(status["job"], "name"));
  } else if (const std::string why = text_of(status, "waiting_for"); !why.empty()) {
    text += ": " + why;
  }
  print(text, text);
}

void ProgressLines::show_job(const Json& status) {
  if (!status["job"].is_object()) return;
  const Json& job = status["job"];
  show_warnings(job);
  const std::string name = text_of(job, "name"), state = text_of(status, "state");
  if (!job.contains("layer")) return print(fmt::format("{}: {}", name, state), state);
  print(line_of(job, state), fmt::format("{} {} {}", static_cast<int>(part_done(job) * 10),
                                         is_worth_a_line(state) ? state : "", text_of(job, "interruption")));
}

void ProgressLines::show_warnings(const Json& job) {
  if (!job.contains("analysis") || !job["analysis"].is_object()) return;
  const std::string name = job.value("name", "");
  for (const Json& each : job["analysis"]["warnings"]) {
    const std::string warning = printable(each.get<std::string>());
    if (warned_.insert(fmt::format("{}\n{}", name, warning)).second)
      fmt::print("{}: warning: {}\n", printable(name), warning);
  }
}

void ProgressLines::print(const std::string& text, const std::string& step) {
  if (step != last_step_) fmt::print("{}\n", text);
  std::fflush(stdout);
  last_step_ = step;
}

}  // namespace contourd::ctl
