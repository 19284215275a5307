// An eventfd, with which one thread wakes another, or the event loop. Any thread may call signal(); only one
// thread may clear() and wait.
#pragma once

namespace contourd {

class EventDescriptor {
 public:
  EventDescriptor();  // throws std::system_error
  EventDescriptor(const EventDescriptor&) = delete;
  EventDescriptor& operator=(const EventDescriptor&) = delete;
  ~EventDescriptor();

  [[nodiscard]] int descriptor() const noexcept { return fd_; }
  // Makes the descriptor readable. One system call; does not block.
  void signal() noexcept;
  // Makes the descriptor unreadable again.
  void clear() noexcept;
  // Blocks until the descriptor is readable.
  void wait() noexcept;

 private:
  int fd_;
};

}  // namespace contourd
