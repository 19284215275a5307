// An eventfd: how one thread wakes another, or the event loop. signal() from any thread, clear() and waiting
// by one.
#pragma once

namespace contourd {

class EventDescriptor {
 public:
  EventDescriptor();  // throws std::system_error
  EventDescriptor(const EventDescriptor&) = delete;
  EventDescriptor& operator=(const EventDescriptor&) = delete;
  ~EventDescriptor();

  [[nodiscard]] int descriptor() const noexcept { return fd_; }
  // Makes it readable. One call of the kernel; does not block.
  void signal() noexcept;
  // Makes it unreadable again.
  void clear() noexcept;
  // Blocks until it is readable.
  void wait() noexcept;

 private:
  int fd_;
};

}  // namespace contourd
