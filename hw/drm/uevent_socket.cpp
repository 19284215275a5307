#include "hw/drm/uevent_socket.hpp"

#include <linux/netlink.h>
#include <sys/socket.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <string_view>
#include <system_error>

namespace contourd {
namespace {

// The multicast group of the kernel's own announcements; group 2 has udev's.
constexpr std::uint32_t kKernelGroup = 1;

FileDescriptor bound_socket() {
  FileDescriptor fd(::socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_KOBJECT_UEVENT));
  sockaddr_nl address{};
  address.nl_family = AF_NETLINK;
  address.nl_groups = kKernelGroup;
  if (!fd.valid() || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::system_error(errno, std::generic_category(), "listening for display hotplug events");
  return fd;
}

// Reads the number that follows `key` in the field. Leaves `number` unchanged if there is none.
void read_number(std::string_view field, std::string_view key, std::optional<std::uint32_t>& number) {
  if (!field.starts_with(key)) return;
  std::uint32_t value = 0;
  const char* const end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data() + key.size(), end, value);
  if (error == std::errc{} && rest == end) number = value;
}

}  // namespace

std::optional<DisplayChange> display_change(std::span<const char> text) {
  bool about_displays = false;
  std::optional<std::uint32_t> major, minor;
  DisplayChange change;
  while (!text.empty()) {
    const auto end = std::ranges::find(text, '\0');
    const std::string_view field(text.data(), static_cast<std::size_t>(end - text.begin()));
    about_displays |= field == "SUBSYSTEM=drm";
    change.of_state |= field == "HOTPLUG=1" || field == "ACTION=remove";
    read_number(field, "CONNECTOR=", change.connector);
    read_number(field, "MAJOR=", major);
    read_number(field, "MINOR=", minor);
    text = text.subspan(std::min(field.size() + 1, text.size()));
  }
  if (!about_displays) return std::nullopt;
  if (major && minor) change.card = makedev(*major, *minor);
  return change;
}

bool concerns(const DisplayChange& change, dev_t card, std::uint32_t connector) {
  return change.of_state && change.card.value_or(card) == card &&
         change.connector.value_or(connector) == connector;
}

UeventSocket::UeventSocket() : fd_(bound_socket()) {}

std::vector<DisplayChange> UeventSocket::read_all() {
  std::vector<DisplayChange> changes;
  char buffer[8192];  // the kernel's limit is 2048 bytes of fields
  for (;;) {
    sockaddr_nl sender{};
    socklen_t size = sizeof sender;
    const ssize_t count =
        ::recvfrom(fd_.get(), buffer, sizeof buffer, 0, reinterpret_cast<sockaddr*>(&sender), &size);
    if (count < 0 && errno == ENOBUFS) {
      changes.push_back({.card = {}, .connector = {}, .of_state = true});  // some were lost
      continue;
    }
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return changes;
    if (sender.nl_pid != 0) continue;  // not from the kernel
    if (const auto change = display_change({buffer, static_cast<std::size_t>(count)}))
      changes.push_back(*change);
  }
}

}  // namespace contourd
