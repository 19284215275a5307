#include "hw/event_descriptor.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace contourd {

EventDescriptor::EventDescriptor() : fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
}

EventDescriptor::~EventDescriptor() {
  close(fd_);
}

void EventDescriptor::signal() noexcept {
  const std::uint64_t one = 1;
  (void)!write(fd_, &one, sizeof one);  // fails only after 2^64 signals without a clear()
}

void EventDescriptor::clear() noexcept {
  std::uint64_t count = 0;
  (void)!read(fd_, &count, sizeof count);
}

void EventDescriptor::wait() noexcept {
  pollfd ready{fd_, POLLIN, 0};
  while (poll(&ready, 1, -1) < 0 && errno == EINTR) {
  }
}

}  // namespace contourd
