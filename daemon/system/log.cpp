#include "daemon/system/log.hpp"
#include "daemon/system/readable.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <functional>
#include <thread>

namespace contourd {
namespace {

using namespace std::chrono_literals;

// About the number of entries of a print of several hours.
constexpr std::size_t kMaxKept = 10'000;
constexpr std::size_t kMaxATurn = 100;
constexpr Duration kJournalRetryInterval = 50ms;
constexpr Duration kFinalFlushTimeout = 1s;
// A datagram holds at most about 200 kB.
constexpr std::size_t kLongestValue = 16'384;
// poll() reports a pipe as writable if PIPE_BUF bytes fit (pipe(7)); 64 of them are for the time and the
// level.
constexpr std::size_t kLongestLine = PIPE_BUF - 64;

// True if stderr is the stream that systemd connected to the journal: JOURNAL_STREAM holds its
// "device:inode". The variable alone is not enough: a program with another stderr may have inherited it.
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

// Appends a field in systemd's native journal protocol: the length of the value as a little-endian number,
// then the value, which may contain any bytes.
void add_field(std::string& entry, std::string_view name, std::string_view whole_value) {
  const std::string_view value = whole_value.substr(0, kLongestValue);
  entry.append(name).append("\n");
  for (unsigned shift = 0; shift < 64; shift += 8)
    entry += static_cast<char>((std::uint64_t{value.size()} >> shift) & 0xFFU);
  entry.append(value).append("\n");
}

std::string journal_entry(LogLevel level, std::string_view event, const std::string& message,
                          const LogFields& fields) {
  std::string entry;
  add_field(entry, "MESSAGE", message);
  add_field(entry, "PRIORITY", std::to_string(static_cast<int>(level)));
  add_field(entry, "EVENT", event);
  add_field(entry, "SYSLOG_IDENTIFIER", "contourd");
  for (const auto& [name, value] : fields)
    add_field(entry, name, printable(value));
  return entry;
}

sockaddr_un journal_address() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  constexpr std::string_view kPath = "/run/systemd/journal/socket";
  kPath.copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

bool stderr_is_writable() {
  pollfd stderr_now{STDERR_FILENO, POLLOUT, 0};
  return ::poll(&stderr_now, 1, 0) != 0;
}

}  // namespace

// The queue of entries that are not delivered yet. It sends journald's datagrams itself, because
// sd_journal_sendv() blocks while journald does not read.
class Log::Backlog {
 public:
  // Calls `on_room` with the number of lost entries once entries are accepted again.
  Backlog(EventLoop& loop, std::function<void(std::uint64_t lost)> on_room)
      : loop_(loop), on_room_(std::move(on_room)) {
    if (stderr_is_journal())
      journal_ = FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  }

  [[nodiscard]] bool to_journal() const { return journal_.valid(); }

  void add(Entry entry) {
    send_kept(kMaxATurn);
    if (kept_.empty() && is_taken(entry)) return;
    if (kept_.size() >= kMaxKept) {
      ++lost_;
      return;
    }
    kept_.push_back(std::move(entry));
    if (!retry_timer_) retry_later();
  }

  void remember(LogLine line) {
    if (recent_.size() >= kMostRecent) recent_.pop_front();
    recent_.push_back(std::move(line));
  }
  [[nodiscard]] const std::deque<LogLine>& recent() const { return recent_; }

  void final_flush() {
    const TimePoint end = std::chrono::steady_clock::now() + kFinalFlushTimeout;
    while (!kept_.empty() && std::chrono::steady_clock::now() < end) {
      if (!send_kept(kMaxKept)) std::this_thread::sleep_for(1ms);
    }
  }

 private:
  // Sends at most `most` entries. Returns false if none was accepted.
  bool send_kept(std::size_t most) {
    std::size_t sent = 0;
    for (; sent < most && !kept_.empty() && is_taken(kept_.front()); ++sent)
      kept_.pop_front();
    return sent > 0;
  }

  // Sends the entry. Returns false if it has to be sent again later; an entry that can never be sent counts
  // as sent.
  bool is_taken(const Entry& entry) const {
    if (!to_journal()) {
      if (!stderr_is_writable()) return false;
      spdlog::default_logger_raw()->log(entry.time, spdlog::source_loc{}, spdlog_level(entry.level),
                                        entry.text);
      return true;
    }
    static const sockaddr_un address = journal_address();
    const ssize_t sent = ::sendto(journal_.get(), entry.text.data(), entry.text.size(), MSG_NOSIGNAL,
                                  reinterpret_cast<const sockaddr*>(&address), sizeof address);
    return sent >= 0 || (errno != EAGAIN && errno != EINTR && errno != ENOBUFS);
  }

  void retry_later() {
    retry_timer_ = loop_.at(std::chrono::steady_clock::now() + kJournalRetryInterval, "the log", [this] {
      retry_timer_.reset();
      send_kept(kMaxATurn);
      if (!kept_.empty()) return retry_later();
      if (lost_ > 0) on_room_(std::exchange(lost_, 0));
    });
  }

  EventLoop& loop_;
  std::function<void(std::uint64_t)> on_room_;
  FileDescriptor journal_;  // invalid if entries go to stderr
  std::deque<Entry> kept_;
  std::deque<LogLine> recent_;
  std::uint64_t lost_ = 0;
  EventLoop::SourcePtr retry_timer_;
};

Log::Log(EventLoop& loop)
    : backlog_(std::make_unique<Backlog>(loop, [this](std::uint64_t lost) {
        warning("log",
                fmt::format("{} log entries were lost: journald or stderr accepted none for a while", lost));
      })) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("contourd", std::make_shared<spdlog::sinks::stderr_color_sink_st>()));
  spdlog::set_pattern("%H:%M:%S.%e %^%-7l%$ %v");
}

Log::~Log() {
  backlog_->final_flush();
}

void Log::write(LogLevel level, std::string_view event, const std::string& message,
                const LogFields& fields) const {
  const std::string clean = printable_lines(message);
  const auto now = std::chrono::system_clock::now();
  backlog_->remember({now, level, std::string(event), shortened(clean, kLongestRecent)});
  std::string text =
      backlog_->to_journal() ? journal_entry(level, event, clean, fields) : clean.substr(0, kLongestLine);
  backlog_->add({level, std::move(text), now});
}

const std::deque<LogLine>& Log::recent() const {
  return backlog_->recent();
}

LogFields job_fields(const std::string& job) {
  return {{"JOB_ID", printable(job)}};
}

}  // namespace contourd
