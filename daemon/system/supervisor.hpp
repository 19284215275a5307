// Notifies the service manager (sd_notify(3)) of readiness and status, and pings its watchdog. Does nothing
// without a service manager. Event loop's thread only.
//
// sd_notify() blocks while the manager does not read. That is right for readiness, but not while a light may
// be on. So the status and the watchdog's pings are sent without blocking, and are lost if the socket's queue
// is full.
#pragma once

#include <sys/un.h>

#include <string>

#include "daemon/system/event_loop.hpp"

namespace contourd {

class Supervisor {
 public:
  // Starts to ping the watchdog if the manager requires it; the pings continue while the loop runs.
  explicit Supervisor(EventLoop& loop);

  // Reports that start-up is complete. Blocks until the manager accepts the message.
  void ready();
  // Reports that the service is stopping.
  void stopping();
  // Sets the status line that `systemctl status` shows.
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
