#include "daemon/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/uio.h>
// The place in this file says nothing about an entry.
#define SD_JOURNAL_SUPPRESS_LOCATION
#include <systemd/sd-journal.h>
#include <unistd.h>

#include <cstdlib>

namespace contourd {
namespace {

// JOURNAL_STREAM is "device:inode" of the stream that systemd connected; it may be inherited by a program
// whose stderr is something else by now.
bool stderr_is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) return false;
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino) == stream;
}

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::Error:
      return spdlog::level::err;
    case LogLevel::Warning:
      return spdlog::level::warn;
    case LogLevel::Info:
      return spdlog::level::info;
  }
  return spdlog::level::info;
}

void send_to_journal(LogLevel level, std::string_view event, const std::string& message,
                     const LogFields& fields) {
  std::vector<std::string> entries{"MESSAGE=" + message,
                                   "PRIORITY=" + std::to_string(static_cast<int>(level)),
                                   "EVENT=" + std::string(event), "SYSLOG_IDENTIFIER=contourd"};
  for (const auto& [name, value] : fields)
    entries.push_back(std::string(name) + "=" + value);
  std::vector<iovec> vectors;
  for (std::string& entry : entries)
    vectors.push_back({entry.data(), entry.size()});
  sd_journal_sendv(vectors.data(), static_cast<int>(vectors.size()));
}

}  // namespace

Log::Log() : journald_(stderr_is_journal()) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("contourd", std::make_shared<spdlog::sinks::stderr_color_sink_st>()));
  spdlog::set_pattern("%H:%M:%S.%e %^%-7l%$ %v");
}

void Log::write(LogLevel level, std::string_view event, const std::string& message,
                const LogFields& fields) const {
  if (journald_) {
    send_to_journal(level, event, message, fields);
  } else {
    spdlog::log(spdlog_level(level), "{}", message);
  }
}

}  // namespace contourd
