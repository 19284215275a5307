// The service manager, as sd_notify(3) knows it: readiness, a status line, the watchdog. Nothing happens
// without one. Event loop's thread only.
//
// sd_notify() waits while the manager does not read. That is right for readiness, and wrong while a light may
// be on: so status and watchdog go out without waiting, and are lost when there is no room for them.
#pragma once

#include <sys/un.h>

#include <string>

#include "daemon/system/event_loop.hpp"

namespace contourd {

class Supervisor {
 public:
  // Begins to ping the watchdog, if the manager asks for that, for as long as the loop turns.
  explicit Supervisor(EventLoop& loop);

  // Start-up is over. Blocks until the manager has room for it.
  void ready();
  // The stop has begun.
  void stopping();
  // For `systemctl status`.
  void status(const std::string& line);

 private:
  void ping();
  void send(const std::string& message);

  EventLoop& loop_;
  FileDescriptor socket_;
  sockaddr_un address_{};
  socklen_t address_bytes_ = 0;
  Duration ping_interval_{};
  EventLoop::SourcePtr ping_timer_;
};

}  // namespace contourd
