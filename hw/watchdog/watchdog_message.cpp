#include "hw/watchdog/watchdog_message.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>

namespace contourd {
namespace {

// Room for one descriptor: the kernel closes what does not fit.
struct DescriptorRoom {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> bytes{};
};

int descriptor_in(msghdr& message) {
  const cmsghdr* control = CMSG_FIRSTHDR(&message);
  if (control == nullptr || control->cmsg_level != SOL_SOCKET || control->cmsg_type != SCM_RIGHTS) return -1;
  int fd = -1;
  std::memcpy(&fd, CMSG_DATA(control), sizeof fd);
  return fd;
}

}  // namespace

std::optional<WatchdogMessageType> WatchdogPacket::type() const {
  if (size < sizeof(WatchdogMessageType)) return std::nullopt;
  WatchdogMessageType type;
  std::memcpy(&type, bytes.data(), sizeof type);
  return type;
}

Received receive_packet(int socket, WatchdogPacket& packet) noexcept {
  iovec bytes{packet.bytes.data(), packet.bytes.size()};
  DescriptorRoom room;
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = room.bytes.data();
  message.msg_controllen = room.bytes.size();
  const ssize_t size = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return Received::Nothing;
  if (size <= 0) return Received::End;
  packet.descriptor = FileDescriptor(descriptor_in(message));
  packet.size = (message.msg_flags & MSG_TRUNC) != 0 ? 0 : static_cast<std::size_t>(size);
  return Received::Packet;
}

bool send_packet(int socket, const void* bytes, std::size_t size, int descriptor) noexcept {
  iovec content{const_cast<void*>(bytes), size};
  DescriptorRoom room;
  msghdr message{};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = room.bytes.data();
    message.msg_controllen = room.bytes.size();
    cmsghdr* const control = CMSG_FIRSTHDR(&message);
    control->cmsg_level = SOL_SOCKET;
    control->cmsg_type = SCM_RIGHTS;
    control->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(control), &descriptor, sizeof descriptor);
  }
  return ::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

}  // namespace contourd
