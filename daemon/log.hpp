// The daemon's log. Under systemd every entry goes to journald with structured fields; otherwise it is a
// readable line on stderr. One line an event: what, value, limit, consequence. From the event loop's thread
// only.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace contourd {

// Priorities of syslog(3).
enum class LogLevel { Error = 3, Warning = 4, Info = 6 };

// Journal fields besides the message; names as journald wants them (upper case): JOB_ID, LAYER, Z_NM, EVENT.
using LogFields = std::vector<std::pair<std::string_view, std::string>>;

class Log {
 public:
  // Chooses journald when stderr is connected to it (JOURNAL_STREAM, systemd.exec(5)).
  Log();

  void write(LogLevel level, std::string_view event, const std::string& message,
             const LogFields& fields = {}) const;

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
  bool journald_;
};

}  // namespace contourd
