#include "daemon/client/daemon_connection.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>

namespace contourd {
namespace {

// Returns a sentence that says why contourd cannot be reached and what to do.
std::string why_unreachable(const std::string& path, int error) {
  const char* const advice =
      error == EACCES
          ? "only root and the group contourd may connect: sudo adduser NAME contourd, then log in again"
          : "systemctl status contourd shows whether it is running";
  return fmt::format("cannot reach contourd on {}: {}; {}", path, std::strerror(error), advice);
}

}  // namespace

DaemonConnection::DaemonConnection(const std::filesystem::path& path,
                                   std::optional<std::chrono::seconds> patience)
    : path_(path.string()), socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path_.size() >= sizeof address.sun_path)
    throw DaemonError(fmt::format("{}: the path is too long", path_));
  std::memcpy(address.sun_path, path_.c_str(), path_.size() + 1);
  if (patience) {
    const timeval longest{patience->count(), 0};
    (void)::setsockopt(socket_.get(), SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof longest);
  }
  if (::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    throw DaemonError(why_unreachable(path_, errno));
  }
}

void DaemonConnection::send(const std::string& method, int id, const Json& parameters) {
  const Json request{{"jsonrpc", "2.0"}, {"method", method}, {"params", parameters}, {"id", id}};
  const std::string line = request.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
  if (::send(socket_.get(), line.data(), line.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(line.size())) {
    throw DaemonError(fmt::format("contourd on {} closed the connection", path_));
  }
}

DaemonConnection::Json DaemonConnection::ask(const Request& request) {
  send(request.method, 1, request.parameters);
  return receive();
}

std::optional<DaemonConnection::Json> DaemonConnection::receive_until(Time time) {
  std::size_t end = 0;
  while ((end = received_.find('\n')) == std::string::npos) {
    if (!wait_until(time)) return std::nullopt;
    std::array<char, 65536> buffer;
    const ssize_t bytes = ::read(socket_.get(), buffer.data(), buffer.size());
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) throw DaemonError(fmt::format("contourd on {} closed the connection", path_));
    received_.append(buffer.data(), static_cast<std::size_t>(bytes));
  }
  const std::string line = received_.substr(0, end);
  received_.erase(0, end + 1);
  return Json::parse(line);
}

bool DaemonConnection::wait_until(Time time) {
  if (time == Time::max()) return true;
  const auto left =
      std::chrono::ceil<std::chrono::milliseconds>(time - std::chrono::steady_clock::now()).count();
  pollfd socket{socket_.get(), POLLIN, 0};
  return ::poll(&socket, 1,
                static_cast<int>(std::clamp<decltype(left)>(left, 0, std::numeric_limits<int>::max()))) != 0;
}

}  // namespace contourd
