// The daemon's log. Under systemd every entry goes to journald with structured fields; otherwise it is a
// readable line on stderr. One line per event: what happened, value, limit, consequence. Event loop's thread
// only.
//
// Logging never blocks, because a light may be on. Entries that journald or stderr does not accept at once
// are kept for a retry; entries beyond the limit are dropped and counted, and the count is logged once there
// is room again.
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/system/event_loop.hpp"

namespace contourd {

// Priorities of syslog(3).
enum class LogLevel { Error = 3, Warning = 4, Info = 6 };

// Journal fields besides the message; names as journald wants them (upper case): JOB_ID, LAYER, Z_NM, EVENT.
using LogFields = std::vector<std::pair<std::string_view, std::string>>;
// Returns the fields of an entry about a job. The job's name may contain any bytes.
[[nodiscard]] LogFields job_fields(const std::string& job);

// An entry as a person reads it.
struct LogLine {
  std::chrono::system_clock::time_point time{};
  LogLevel level = LogLevel::Info;
  std::string event,
      message;  // the message is printable, and at most Log::kLongestRecent bytes and a note long
};

class Log {
 public:
  // The latest entries are kept in memory, shortened, for clients of the control socket.
  static constexpr std::size_t kMostRecent = 200, kLongestRecent = 400;

  // Chooses journald when stderr is connected to it (JOURNAL_STREAM, systemd.exec(5)).
  explicit Log(EventLoop& loop);
  // Tries to deliver the pending entries for up to a second.
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void write(LogLevel level, std::string_view event, const std::string& message,
             const LogFields& fields = {}) const;

  // Returns the latest entries, the oldest first.
  [[nodiscard]] const std::deque<LogLine>& recent() const;

  void error(std::string_view event, const std::string& message, const LogFields& fields = {}) const {
    write(LogLevel::Error, event, message, fields);
  }
  void warning(std::string_view event, const std::string& message, const LogFields& fields = {}) const {
    write(LogLevel::Warning, event, message, fields);
  }
  void info(std::string_view event, const std::string& message, const LogFields& fields = {}) const {
    write(LogLevel::Info, event, message, fields);
  }

 private:
  struct Entry {
    LogLevel level = LogLevel::Info;
    std::string text;  // in journald's protocol, or a line for a person
    std::chrono::system_clock::time_point time{};
  };
  class Backlog;

  std::unique_ptr<Backlog> backlog_;
};

}  // namespace contourd
