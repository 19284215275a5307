#include "daemon/system/supervisor.hpp"
#include "daemon/system/readable.hpp"

#include <sys/socket.h>
#include <systemd/sd-daemon.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace contourd {

Supervisor::Supervisor(EventLoop& loop) : loop_(loop) {
  const char* path = std::getenv("NOTIFY_SOCKET");
  const std::string_view name = path != nullptr ? path : "";
  if (!name.empty() && name.size() < sizeof address_.sun_path) {
    address_.sun_family = AF_UNIX;
    std::memcpy(address_.sun_path, name.data(), name.size());
    if (name.front() == '@') address_.sun_path[0] = '\0';  // the abstract namespace, unix(7)
    address_bytes_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    socket_ = FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  }
  std::uint64_t timeout_us = 0;
  if (sd_watchdog_enabled(0, &timeout_us) <= 0) return;
  // sd_watchdog_enabled(3) recommends half of the timeout; 2/5 leaves some margin.
  ping_interval_ = std::chrono::microseconds(timeout_us) * 2 / 5;
  ping();
}

void Supervisor::ready() {
  sd_notify(0, "READY=1");
}

void Supervisor::stopping() {
  send("STOPPING=1");
}

void Supervisor::status(const std::string& line) {
  send("STATUS=" + printable(line));
}

void Supervisor::ping() {
  send("WATCHDOG=1");
  ping_timer_ =
      loop_.at(std::chrono::steady_clock::now() + ping_interval_, "the watchdog's timer", [this] { ping(); });
}

void Supervisor::send(const std::string& message) {
  if (!socket_.valid()) return;
  const auto* address = reinterpret_cast<const sockaddr*>(&address_);
  // Ignore errors, such as a full queue or a manager that is gone: the print goes on.
  [[maybe_unused]] const ssize_t sent = ::sendto(socket_.get(), message.data(), message.size(),
                                                 MSG_NOSIGNAL | MSG_DONTWAIT, address, address_bytes_);
}

}  // namespace contourd
