#include "hw/drm/uevent_socket.hpp"

#include <linux/netlink.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <string_view>
#include <system_error>

namespace contourd {
namespace {

// The kernel's own announcements; group 2 has udev's.
constexpr std::uint32_t kKernelGroup = 1;

FileDescriptor bound_socket() {
  FileDescriptor fd(::socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_KOBJECT_UEVENT));
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = kKernelGroup;
  if (!fd.valid() || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::system_error(errno, std::generic_category(), "hearing of displays plugged in and out");
  return fd;
}

}  // namespace

bool is_about_displays(std::span<const char> text) {
  while (!text.empty()) {
    const auto end = std::ranges::find(text, '\0');
    const std::string_view field(text.data(), static_cast<std::size_t>(end - text.begin()));
    if (field == "SUBSYSTEM=drm") return true;
    text = text.subspan(std::min(field.size() + 1, text.size()));
  }
  return false;
}

UeventSocket::UeventSocket() : fd_(bound_socket()) {}

bool UeventSocket::read_all() {
  bool about_displays = false;
  char buffer[8192];  // the kernel's limit is 2048 bytes of fields
  for (;;) {
    sockaddr_nl sender{};
    socklen_t size = sizeof sender;
    const ssize_t count =
        ::recvfrom(fd_.get(), buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&sender), &size);
    if (count < 0 && errno == ENOBUFS) {
      about_displays = true;  // some were lost: look for oneself
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return about_displays;
    const bool from_kernel = sender.nl_pid == 0;
    if (from_kernel && is_about_displays({buffer, static_cast<std::size_t>(count)})) about_displays = true;
  }
}

}  // namespace contourd
