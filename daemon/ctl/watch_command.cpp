#include "daemon/ctl/watch_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

#include "daemon/ctl/daemon_connection.hpp"
#include "daemon/ctl/exit_codes.hpp"
#include "daemon/ctl/progress_view.hpp"
#include "daemon/readable.hpp"
#include "daemon/spool_folders.hpp"

namespace contourd::ctl {
namespace {

using namespace std::chrono_literals;
using Json = DaemonConnection::Json;

// How long a job may be nowhere: the daemon needs a moment to see a file, and looks at it again when it may
// still grow.
constexpr auto kLongestAbsence = 3s;
constexpr auto kAskInterval = 500ms;

int print_end(const Json& ended, bool json) {
  const std::string outcome = ended.value("outcome", ""), reason = ended.value("reason", "");
  if (!json) {
    fmt::print("{}: {}{}\n", printable(ended.value("job", "")), printable(outcome),
               reason.empty() ? "" : ": " + printable_lines(reason));
  }
  return outcome == "done" ? kOk : kFailed;
}

void print_line(const Json& message) {
  fmt::print("{}\n", message.dump(-1, ' ', true));
  std::fflush(stdout);
}

bool names(const Json& files, const std::string& job) {
  return std::ranges::any_of(files,
                             [&](const Json& file) { return job_name_of(file.get<std::string>()) == job; });
}

// One job that is waited for, wherever it is: being copied, in the queue, under way, ended.
class WantedJob {
 public:
  explicit WantedJob(std::string name) : name_(std::move(name)) {}

  void note_status(const Json& status) {
    is_under_way_ = status["job"].is_object() && status["job"].value("name", "") == name_;
    if (is_under_way_) last_seen_ = std::chrono::steady_clock::now();
  }
  // False when it is not there any more, or never was.
  [[nodiscard]] bool note_queue(const Json& result) {
    const auto now = std::chrono::steady_clock::now();
    // Of a longer queue only its beginning is told.
    if (is_under_way_ || names(result["queue"], name_) || names(result["arriving"], name_) ||
        result.value("more", 0) > 0)
      last_seen_ = now;
    return now - last_seen_ < kLongestAbsence;
  }
  // The end of the job of that name that came last, if it is known.
  [[nodiscard]] std::optional<Json> end_in(const Json& history) const {
    const Json& ended = history["ended"];
    for (auto each = ended.rbegin(); each != ended.rend(); ++each) {
      if (each->value("job", "") == name_) return *each;
    }
    return std::nullopt;
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool is_under_way() const { return is_under_way_; }

 private:
  std::string name_;
  bool is_under_way_ = false;
  std::chrono::steady_clock::time_point last_seen_ = std::chrono::steady_clock::now();
};

// Answers have the number of their question; those to questions that were asked again are not for the user.
enum Question { kWatch = 1, kStatus, kHistory, kQueue, kStatusAgain, kHistoryAgain, kQueueAgain };

int watch_any(DaemonConnection& connection, bool json) {
  connection.send("watch", kWatch);
  connection.send("status", kStatus);
  ProgressView view;
  std::string under_way;
  while (true) {
    const Json message = connection.receive();
    if (json) print_line(message);
    const bool first = message.value("id", 0) == kStatus;
    if (!first && !message.contains("params")) continue;
    const Json& status = first ? message["result"] : message["params"];
    const bool any_ended = message.value("method", "") == "ended";
    if (!any_ended && status["job"].is_object()) under_way = status["job"].value("name", "");
    if (!json) view.show(status);
    // A refusal in the queue is not the end of the print that is being watched.
    if (!any_ended || (!under_way.empty() && status["last"].value("job", "") != under_way)) continue;
    if (!json) view.end();
    return print_end(status["last"], json);
  }
}

// What is found in the message about the job: its exit code once it has ended or is nowhere.
std::optional<int> look_for(WantedJob& job, const Json& message, ProgressView& view, bool json) {
  const int id = message.value("id", 0);
  if (id == kHistory || id == kHistoryAgain) {
    const auto end = job.end_in(message["result"]);
    if (!end) return std::nullopt;
    if (!json) view.end();
    return print_end(*end, json);
  }
  if (id == kQueue || id == kQueueAgain) {
    if (job.note_queue(message["result"])) return std::nullopt;
    if (!json) view.end();
    fmt::print(stderr,
               "contourctl: there is no job {}: it neither waits nor is it being printed, nor is it one of "
               "the last that "
               "ended\n",
               printable(job.name()));
    return kFailed;
  }
  const bool status_answer = id == kStatus || id == kStatusAgain;
  if (!status_answer && !message.contains("params")) return std::nullopt;
  const Json& status = status_answer ? message["result"] : message["params"];
  job.note_status(status);
  if (!json) view.show_job(status, job.name(), job.is_under_way());
  if (message.value("method", "") != "ended" || status["last"].value("job", "") != job.name())
    return std::nullopt;
  if (!json) view.end();
  return print_end(status["last"], json);
}

int watch_job(DaemonConnection& connection, WantedJob job, bool json) {
  connection.send("watch", kWatch);
  connection.send("status", kStatus);
  connection.send("history", kHistory);
  connection.send("queue", kQueue);
  ProgressView view;
  auto ask_at = std::chrono::steady_clock::now() + kAskInterval;
  while (true) {
    const std::optional<Json> message = connection.receive_until(ask_at);
    if (message && json && message->value("id", 0) <= kQueue) print_line(*message);
    if (message) {
      if (const std::optional<int> code = look_for(job, *message, view, json)) return *code;
    }
    if (std::chrono::steady_clock::now() < ask_at) continue;
    ask_at = std::chrono::steady_clock::now() + kAskInterval;
    if (job.is_under_way()) continue;  // its end will be told
    connection.send("status", kStatusAgain);
    connection.send("history", kHistoryAgain);
    connection.send("queue", kQueueAgain);
  }
}

}  // namespace

int watch(const ClientOptions& options, const std::optional<std::string>& job) {
  DaemonConnection connection(options.socket);
  return job ? watch_job(connection, WantedJob(job_name_of(*job)), options.json)
             : watch_any(connection, options.json);
}

}  // namespace contourd::ctl
