#include "daemon/ctl/watch/watch_end.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/spool/spool_folders.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using namespace std::chrono_literals;
using Json = WatchEnd::Json;

// Time for which a job may be unknown: the daemon needs a moment to notice a file, and waits until the file
// does not grow any more.
constexpr auto kLongestAbsence = 3s;

// Numbers of requests, which their answers repeat. Answers to ...Again are not shown to the user.
enum Question { kWatch = 1, kStatus, kHistory, kQueue, kStatusAgain, kHistoryAgain, kQueueAgain };

int question_of(const Json& message) {
  return message.contains("result") ? message.value("id", 0) : 0;
}

bool names(const Json& files, const std::string& job) {
  return std::ranges::any_of(files,
                             [&](const Json& file) { return job_name_of(file.get<std::string>()) == job; });
}

}  // namespace

WatchEnd::WatchEnd(const std::optional<std::string>& job) : job_(job ? job_name_of(*job) : "") {}

void WatchEnd::begin(DaemonConnection& connection) {
  under_way_.clear();
  is_under_way_ = false;
  last_seen_ = std::chrono::steady_clock::now();
  connection.send("watch", kWatch);
  connection.send("status", kStatus);
  if (job_.empty()) return;
  connection.send("history", kHistory, {{"this_run", true}, {"job", job_}});
  connection.send("queue", kQueue);
}

void WatchEnd::ask_again(DaemonConnection& connection) const {
  if (job_.empty() || is_under_way_) return;  // contourd will report its end
  connection.send("status", kStatusAgain);
  connection.send("history", kHistoryAgain, {{"this_run", true}, {"job", job_}});
  connection.send("queue", kQueueAgain);
}

void WatchEnd::ask_status(DaemonConnection& connection) const {
  connection.send("status", kStatusAgain);
}

void WatchEnd::ask_queue(DaemonConnection& connection) const {
  connection.send("queue", kQueueAgain);
}

const Json* WatchEnd::status_in(const Json& message) {
  const int question = question_of(message);
  if (question == kStatus || question == kStatusAgain) return &message["result"];
  return message.contains("params") ? &message["params"] : nullptr;
}

const Json* WatchEnd::queue_in(const Json& message) {
  const int question = question_of(message);
  return question == kQueue || question == kQueueAgain ? &message["result"] : nullptr;
}

bool WatchEnd::is_repeated(const Json& message) {
  return message.value("id", 0) > kQueue;
}

void WatchEnd::note_seen() {
  last_seen_ = std::chrono::steady_clock::now();
  is_known_ = true;
}

bool WatchEnd::note_queue(const Json& result) {
  // contourd lists only the beginning of a long queue, so the job may be in the rest.
  if (is_under_way_ || names(result["queue"], job_) || names(result["arriving"], job_) ||
      result.value("more", 0) > 0)
    note_seen();
  return std::chrono::steady_clock::now() - last_seen_ < kLongestAbsence;
}

std::optional<Json> WatchEnd::end_in(const Json& history) const {
  const Json& ended = history["ended"];
  for (auto each = ended.rbegin(); each != ended.rend(); ++each) {
    if (each->value("job", "") == job_) return *each;
  }
  return std::nullopt;
}

std::optional<Json> WatchEnd::take(const Json& message) {
  const int question = question_of(message);
  if (!job_.empty() && (question == kHistory || question == kHistoryAgain)) return end_in(message["result"]);
  if (!job_.empty() && queue_in(message) != nullptr && !note_queue(*queue_in(message))) {
    throw NoSuchJob{
        fmt::format("there is no job {}: it is not waiting, not being printed, and not among the jobs that "
                    "ended recently",
                    printable(job_))};
  }
  const Json* const status = status_in(message);
  if (status == nullptr) return std::nullopt;
  const bool any_ended = message.value("method", "") == "ended";
  const std::string name = (*status)["job"].is_object() ? (*status)["job"].value("name", "") : "";
  if (!any_ended && !name.empty()) under_way_ = name;
  is_under_way_ = !job_.empty() && name == job_;
  if (is_under_way_) note_seen();
  if (!any_ended) return std::nullopt;
  // A refusal in the queue is not the end of the print that is being watched.
  const Json& last = (*status)["last"];
  const std::string& wanted = job_.empty() ? under_way_ : job_;
  if (!wanted.empty() && last.value("job", "") != wanted) return std::nullopt;
  return last;
}

}  // namespace contourd::ctl
