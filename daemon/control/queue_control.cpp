#include "daemon/control/queue_control.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/system_users.hpp"

namespace contourd {

using Json = QueueControl::Json;

namespace {

// Maximum number of jobs that a message names.
constexpr std::size_t kMostNamed = 5;

std::string job_of(const Json& given) {
  return given["job"].get<std::string>();
}

void refuse_leaving(const WaitingJob& job) {
  if (job.check == WaitingJob::Check::Refused)
    throw ControlRefusal(fmt::format("{} is already being moved to failed", in_quotes(job.file)));
}

// Returns the place, counted from 0.
std::size_t place_in(const Json& given) {
  return given["to"] == "last" ? PrintQueue::kMaxInOrder : given["to"].get<std::size_t>() - 1;
}

}  // namespace

ControlMethods QueueControl::methods() {
  const ControlParameter job =
      ControlParameter::text("job",
                             "the job: its file in `incoming/`, its name, or the printable form of either")
          .described_as("the name of a waiting job");
  ControlParameter place =
      ControlParameter::whole_number("to", 1, PrintQueue::kMaxInOrder, "the new place, counted from 1")
          .described_as(fmt::format("a place from 1 to {}, or \"last\"", PrintQueue::kMaxInOrder))
          .needed();
  place.words = {"last"};
  return {{"queue",
           {.description = "Reports the waiting jobs, or all details of one job.",
            .parameters = {job},
            .call = [this](const Json& given, const ControlCaller&) { return look(given); }}},
          {"queue_remove",
           {.description = "Removes a job from the queue: its files go to `failed/`.",
            .parameters = {job.needed()},
            .call = [this](const Json& given, const ControlCaller& caller) { return remove(given, caller); },
            .changes = true}},
          {"queue_move",
           {.description = "Moves a job to another place in the queue.",
            .parameters = {job.needed(), place},
            .call = [this](const Json& given, const ControlCaller&) { return move(given); },
            .changes = true}},
          {"accept",
           {.description = "Accepts a job that waits because of findings in its models or layers.",
            .parameters = {job.needed()},
            .call = [this](const Json& given, const ControlCaller& caller) { return accept(given, caller); },
            .changes = true}}};
}

Json QueueControl::look(const Json& given) const {
  if (!given.contains("job")) return status_.queue();
  return status_.queue(number_of(job_of(given)));
}

Json QueueControl::remove(const Json& given, const ControlCaller& caller) {
  const WaitingJob& job = queue_.jobs()[number_of(job_of(given))];
  refuse_leaving(job);
  queue_.remove(std::string(job.file),
                fmt::format("removed from the queue by user {}", user_name(caller.user)));
  return status_.queue();
}

Json QueueControl::move(const Json& given) {
  const std::size_t from = number_of(job_of(given));
  const std::size_t to = std::min(place_in(given), queue_.jobs().size() - 1);
  if (std::max(from, to) >= PrintQueue::kMaxInOrder)
    throw ControlRefusal(fmt::format("only the first {} jobs can be moved, and only among themselves",
                                     PrintQueue::kMaxInOrder));
  queue_.move(std::string(queue_.jobs()[from].file), to);
  return status_.queue();
}

Json QueueControl::accept(const Json& given, const ControlCaller& caller) {
  const std::string name = job_of(given);
  const std::optional<std::size_t> number = find(name);
  if (!number) refuse_to_accept(name);
  const WaitingJob& job = queue_.jobs()[*number];
  refuse_leaving(job);
  if (job.asks.empty() && !queue_.questions().wanted())
    throw ControlRefusal(
        fmt::format("{} need not be accepted: this printer's ask_before is empty", in_quotes(job.file)));
  if (!job.analyzed)
    throw ControlRefusal(
        fmt::format("{} is not analyzed yet: its findings are unknown", in_quotes(job.file)));
  if (job.asks.empty())
    throw ControlRefusal(fmt::format("{} does not wait to be accepted", in_quotes(job.file)));
  queue_.accept(std::string(job.file), fmt::format("user {}", user_name(caller.user)));
  return status_.queue();
}

void QueueControl::refuse_to_accept(const std::string& job) const {
  if (job_.job() != nullptr && job_.name() == job_name_of(job))
    throw ControlRefusal(
        fmt::format("{} no longer waits, its turn has come: there is nothing to accept", in_quotes(job)));
  std::string unaccepted;
  std::size_t named = 0;
  for (const WaitingJob& each : queue_.jobs()) {
    if (each.asks.empty()) continue;
    if (named++ == kMostNamed) {
      unaccepted += " and others";
      break;
    }
    unaccepted += (unaccepted.empty() ? "" : ", ") + in_quotes(job_name_of(each.file));
  }
  throw ControlRefusal(
      fmt::format("no job {} waits{}", in_quotes(job),
                  unaccepted.empty() ? "" : "; jobs that wait to be accepted: " + unaccepted));
}

// Matches the file's name first, then the job's name, then the printable form of either, because a user
// cannot type unprintable characters.
std::optional<std::size_t> QueueControl::find(const std::string& job) const {
  const auto& jobs = queue_.jobs();
  const std::vector<std::function<bool(const std::string&)>> matches{
      [&](const std::string& file) { return file == job; },
      [&](const std::string& file) { return job_name_of(file) == job; },
      [&](const std::string& file) { return printable(file) == job || printable(job_name_of(file)) == job; }};
  for (const auto& is_meant : matches) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < jobs.size() && found.size() < kMostNamed; ++i)
      if (is_meant(jobs[i].file)) found.push_back(i);
    if (found.size() == 1) return found.front();
    if (found.empty()) continue;
    std::string files;
    for (const std::size_t each : found)
      files += (files.empty() ? "" : ", ") + in_quotes(jobs[each].file);
    throw ControlRefusal(fmt::format("more than one job is called {}: {}", in_quotes(job), files));
  }
  return std::nullopt;
}

std::size_t QueueControl::number_of(const std::string& job) const {
  if (const std::optional<std::size_t> number = find(job)) return *number;
  if (job_.job() != nullptr && job_.name() == job_name_of(job))
    throw ControlRefusal(
        fmt::format("{} no longer waits, its turn has come: cancel ends it", in_quotes(job)));
  throw ControlRefusal(fmt::format("no job {} waits", in_quotes(job)));
}

}  // namespace contourd
