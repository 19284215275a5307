#include "daemon/history/ended_job_notices.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "daemon/system/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kLongestReason = 2000;  // bytes
// Delay before a notice is sent again to a socket whose queue is full.
constexpr Duration kNoticeRetryInterval = 2s;

std::string as_json(const EndedJob& job, const std::string& printer, const std::string& reason) {
  const auto path = [](const std::filesystem::path& file) {
    return file.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(printable(file.string()));
  };
  const nlohmann::ordered_json notice{{"printer", printable(printer)},
                                      {"job", printable(job.name)},
                                      {"outcome", job.outcome},
                                      {"reason", reason},
                                      {"report_json", path(job.reports.json)},
                                      {"report_html", path(job.reports.html)}};
  return notice.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::string notice_of(const EndedJob& job, const std::string& printer) {
  const std::string reason = shortened(printable(job.reason), kLongestReason);
  std::string notice;
  const auto add = [&notice](std::string_view name, std::string_view value) {
    notice += fmt::format("CONTOURD_{}={}", name, value);
    notice += '\0';
  };
  add("PRINTER", printable(printer));
  add("JOB", printable(job.name));
  add("OUTCOME", job.outcome);
  add("REASON", reason);
  add("REPORT_JSON", job.reports.json.native());
  add("REPORT_HTML", job.reports.html.native());
  add("NOTICE", as_json(job, printer, reason));
  return notice;
}

EndedJobNotices::EndedJobNotices(EventLoop& loop, const Log& log, std::filesystem::path socket,
                                 std::string printer, Sent sent)
    : loop_(loop),
      log_(log),
      socket_(std::move(socket)),
      printer_(std::move(printer)),
      sent_(std::move(sent)) {}

EndedJobNotices::~EndedJobNotices() {
  // The event loop has stopped, so the connections cannot be watched.
  for (FileDescriptor socket; !waiting_.empty() && send(waiting_.front().notice, socket) == Delivery::Taken;)
    finish_first();
}

void EndedJobNotices::add(const EndedJob& job) {
  if (waiting_.size() < kMostWaiting) {
    waiting_.push_back({notice_of(job, printer_), job.key});
    return hand_over();
  }
  if (std::exchange(too_many_logged_, true)) return;
  log_.warning(
      "notice",
      fmt::format("{}: no notice is sent of its end, nor of other jobs, because {} notices are waiting: the "
                  "commands that {} starts do not end",
                  printable(job.name), waiting_.size(), printable(socket_.string())),
      job_fields(job.name));
}

void EndedJobNotices::hand_over() {
  while (!waiting_.empty() && open_.size() < kMostOpen) {
    FileDescriptor socket;
    switch (send(waiting_.front().notice, socket)) {
      case Delivery::Taken:
        watch(std::move(socket));
        finish_first();
        too_many_logged_ = false;
        break;
      case Delivery::Busy:
        timer_ = loop_.at(std::chrono::steady_clock::now() + kNoticeRetryInterval, "a notice's timer",
                          [this] { hand_over(); });
        return;
      case Delivery::NoListener:
      case Delivery::Refused:
        while (!waiting_.empty())
          finish_first();
    }
  }
}

void EndedJobNotices::finish_first() {
  sent_(waiting_.front().key);
  waiting_.pop_front();
}

EndedJobNotices::Delivery EndedJobNotices::send(const std::string& notice, FileDescriptor& socket) {
  socket = FileDescriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  socket_.native().copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
  const auto refused = [this](int error) {
    note_trouble(std::generic_category().message(error));
    return Delivery::Refused;
  };
  if (!socket.valid()) return refused(errno);
  // A Unix stream socket connects at once, or fails because the listener's queue is full.
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno == ENOENT || errno == ECONNREFUSED) return Delivery::NoListener;
    return errno == EAGAIN ? Delivery::Busy : refused(errno);
  }
  // The buffer of a new connection is larger than the longest notice.
  const ssize_t sent = ::send(socket.get(), notice.data(), notice.size(), MSG_NOSIGNAL);
  if (sent < 0) return refused(errno);
  if (static_cast<std::size_t>(sent) != notice.size()) return refused(ENOBUFS);
  ::shutdown(socket.get(), SHUT_WR);
  trouble_.clear();
  return Delivery::Taken;
}

// Waits for the other end to close the connection. Data from there is not read, so its sender can fill at
// most the socket's buffer.
void EndedJobNotices::watch(FileDescriptor socket) {
  const auto notice = open_.insert(open_.end(), Notice{std::move(socket), nullptr});
  notice->end =
      loop_.on_ready(notice->socket.get(), EPOLLRDHUP, "a notice's end", [this, notice](std::uint32_t) {
        open_.erase(notice);
        hand_over();
      });
}

void EndedJobNotices::note_trouble(const std::string& trouble) {
  if (std::exchange(trouble_, trouble) == trouble) return;
  log_.warning("notice", fmt::format("cannot send notices of ended jobs to {}: {}",
                                     printable(socket_.string()), printable(trouble)));
}

}  // namespace contourd
