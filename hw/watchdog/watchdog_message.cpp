#include "hw/watchdog/watchdog_message.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <cerrno>

namespace contourd {
namespace {

// Control buffer for one descriptor; the kernel closes those that do not fit.
struct DescriptorBuffer {
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
  DescriptorBuffer control_buffer;
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = control_buffer.bytes.data();
  message.msg_controllen = control_buffer.bytes.size();
  const ssize_t size = ::recvmsg(socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return Received::Nothing;
  if (size <= 0) return Received::End;
  packet.descriptor = FileDescriptor(descriptor_in(message));
  packet.size = (message.msg_flags & MSG_TRUNC) != 0 ? 0 : static_cast<std::size_t>(size);
  return Received::Packet;
}

bool send_packet(int socket, const void* bytes, std::size_t size, int descriptor) noexcept {
  iovec content{const_cast<void*>(bytes), size};
  DescriptorBuffer control_buffer;
  msghdr message{};
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  if (descriptor >= 0) {
    message.msg_control = control_buffer.bytes.data();
    message.msg_controllen = control_buffer.bytes.size();
    cmsghdr* const control = CMSG_FIRSTHDR(&message);
    control->cmsg_level = SOL_SOCKET;
    control->cmsg_type = SCM_RIGHTS;
    control->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(control), &descriptor, sizeof descriptor);
  }
  return ::sendmsg(socket, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

}  // namespace contourd
