#include "daemon/camera/camera_call.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "daemon/system/readable.hpp"
#include "hw/file_descriptor.hpp"

namespace contourd {
namespace {

using namespace std::string_view_literals;
using SteadyClock = std::chrono::steady_clock;

// An answer of with-camera instead of a file: "trouble: " and a clause; or that there is no command.
constexpr std::string_view kTrouble = "trouble: ", kNone = "none\n";
constexpr std::size_t kLongestTrouble = 200;  // bytes

std::string text_of(const CameraCall& call) {
  std::string text;
  for (const auto& [name, value] : call.variables) {
    text += fmt::format("CONTOURD_{}={}", name, value);
    text += '\0';
  }
  return text;
}

// Returns a connection to the service; a sentence in `trouble` if there is none.
FileDescriptor connect_to(const std::filesystem::path& path, std::string& trouble) {
  FileDescriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.native().copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
  if (socket.valid() &&
      ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return socket;
  const int error = errno;
  trouble = error == ENOENT || error == ECONNREFUSED
                ? fmt::format(
                      "no service listens at {}; enable it with \"systemctl enable --now "
                      "contourd-camera.socket\"",
                      printable(path.string()))
                : fmt::format("{} cannot be reached: {}", printable(path.string()), std::strerror(error));
  return {};
}

// Returns the clause of an answer without a file; the answer if it has one.
CameraAnswer judged(std::string bytes) {
  if (bytes == kNone) return {};
  if (bytes.empty()) return {.trouble = "its command has sent nothing"};
  if (!bytes.starts_with(kTrouble)) return {.bytes = std::move(bytes)};
  std::string_view clause = std::string_view(bytes).substr(kTrouble.size());
  clause = clause.substr(0, std::min(clause.find('\n'), kLongestTrouble));
  return {.trouble = printable(clause)};
}

}  // namespace

CameraAnswer call_camera(const CameraCall& call, int stop) {
  const SteadyClock::time_point deadline = SteadyClock::now() + call.patience;
  CameraAnswer answer;
  const FileDescriptor socket = connect_to(call.socket, answer.trouble);
  if (!socket.valid()) return answer;
  // The buffer of a new connection is larger than the longest text.
  const std::string text = text_of(call);
  if (::send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(text.size()))
    return {.trouble = "its service does not take what the command has to know"};
  ::shutdown(socket.get(), SHUT_WR);
  std::string bytes;
  std::array<char, 65'536> buffer{};
  while (true) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - SteadyClock::now()).count();
    if (left <= 0)
      return {.trouble = fmt::format("its service has not answered within {}", readable(call.patience))};
    std::array<pollfd, 2> ready{pollfd{socket.get(), POLLIN, 0}, pollfd{stop, POLLIN, 0}};
    if (::poll(ready.data(), ready.size(), static_cast<int>(std::min<long>(left, 60'000))) <= 0) continue;
    if (ready[1].revents != 0) return {.trouble = "contourd stops"};
    const ssize_t got = ::recv(socket.get(), buffer.data(), buffer.size(), 0);
    if (got == 0) return judged(std::move(bytes));
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (got < 0) return {.trouble = fmt::format("its service has failed: {}", std::strerror(errno))};
    if (bytes.size() + static_cast<std::size_t>(got) > kMostCameraBytes)
      return {.trouble = fmt::format("its command has sent more than {} MiB", kMostCameraBytes >> 20U)};
    bytes.append(buffer.data(), static_cast<std::size_t>(got));
  }
}

bool is_jpeg(std::string_view bytes) {
  return bytes.starts_with("\xff\xd8\xff"sv);
}

bool is_mp4(std::string_view bytes) {
  constexpr std::size_t kTypeAt = 4;
  return bytes.size() > kTypeAt && bytes.substr(kTypeAt).starts_with("ftyp");
}

}  // namespace contourd
