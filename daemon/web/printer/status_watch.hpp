// The printer's status, kept up to date: asks contourd, subscribes to its notifications, and passes each
// status on. Event loop's thread only.
#pragma once

#include <filesystem>
#include <functional>

#include "daemon/system/event_loop.hpp"
#include "daemon/web/printer/control_link.hpp"

namespace contourd::web {

class StatusWatch {
 public:
  using Json = ControlLink::Json;
  // Gets a status, which may equal the one before; or {"unreachable": "why"}.
  using Told = std::function<void(const Json& status)>;

  StatusWatch(EventLoop& loop, const std::filesystem::path& socket, Told told);
  StatusWatch(const StatusWatch&) = delete;
  StatusWatch& operator=(const StatusWatch&) = delete;

  // Connects to contourd's control socket, and again whenever the connection is lost.
  void start();
  // Closes the connection, and makes no call afterwards.
  void stop();

 private:
  void ask();
  void watch();

  EventLoop& loop_;
  Told told_;
  ControlLink link_;
  bool running_ = false, watching_ = false, asked_ = false;
  EventLoop::SourcePtr ask_timer_;
};

}  // namespace contourd::web
