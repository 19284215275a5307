// Takes logind's inhibitor locks over the system message bus (sd-bus; org.freedesktop.login1(5)). Never
// blocks. Without a bus every lock is refused. Event loop's thread only.
#pragma once

#include <systemd/sd-bus.h>

#include <list>
#include <memory>
#include <string>

#include "daemon/app/sleep_inhibitor.hpp"
#include "daemon/system/event_loop.hpp"

namespace contourd {

class LoginBus final : public SleepAuthority {
 public:
  // The loop must outlive the object.
  explicit LoginBus(EventLoop& loop);

  void take(Lock lock, Taken taken) override;
  void on_sleep(std::function<void(bool asleep)> call) override { on_sleep_ = std::move(call); }

 private:
  struct Closer {
    void operator()(sd_bus* bus) const { sd_bus_close_unref(bus); }
  };
  struct Request {
    LoginBus& bus;
    Taken taken;
  };

  void connect();
  static int prepare_for_sleep(sd_bus_message* message, void* self, sd_bus_error* error);
  static int answered(sd_bus_message* message, void* request, sd_bus_error* error);
  void answer(std::list<Request>::iterator request, FileDescriptor lock, const std::string& refusal);

  EventLoop& loop_;
  // Defers all callbacks of the bus to the event loop, so that no exception passes through the library.
  Mailbox mailbox_;
  std::unique_ptr<sd_bus, Closer> bus_;
  std::string why_no_bus_;
  std::list<Request> requests_;
  std::function<void(bool)> on_sleep_;
};

}  // namespace contourd
