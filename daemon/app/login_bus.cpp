#include "daemon/app/login_bus.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cstring>
#include <utility>

namespace contourd {
namespace {

constexpr const char* kService = "org.freedesktop.login1";
constexpr const char* kPath = "/org/freedesktop/login1";
constexpr const char* kInterface = "org.freedesktop.login1.Manager";

}  // namespace

LoginBus::LoginBus(EventLoop& loop) : loop_(loop), mailbox_(loop) {
  connect();
}

// Connects unless the connection is still open: the bus may have been restarted since.
void LoginBus::connect() {
  if (bus_ && sd_bus_is_open(bus_.get()) > 0) return;
  sd_bus* bus = nullptr;
  int result = sd_bus_open_system(&bus);
  bus_.reset(bus);
  if (result >= 0) {
    loop_.attach(bus);
    result = sd_bus_match_signal_async(bus, nullptr, kService, kPath, kInterface, "PrepareForSleep",
                                       prepare_for_sleep, nullptr, this);
  }
  if (result >= 0) return;
  why_no_bus_ = std::string("the system message bus: ") + std::strerror(-result);
  bus_.reset();
}

int LoginBus::prepare_for_sleep(sd_bus_message* message, void* self, sd_bus_error*) {
  int asleep = 0;
  if (sd_bus_message_read(message, "b", &asleep) < 0) return 0;
  auto& bus = *static_cast<LoginBus*>(self);
  bus.mailbox_.post([&bus, asleep] {
    if (bus.on_sleep_) bus.on_sleep_(asleep != 0);
  });
  return 0;
}

void LoginBus::take(Lock lock, Taken taken) {
  connect();
  const auto request = requests_.insert(requests_.end(), Request{*this, std::move(taken)});
  const int result =
      bus_ ? sd_bus_call_method_async(bus_.get(), nullptr, kService, kPath, kInterface, "Inhibit", answered,
                                      &*request, "ssss", "sleep", "contourd", "A print is running",
                                      lock == Lock::Block ? "block" : "delay")
           : -ENOTCONN;
  if (result < 0) answer(request, FileDescriptor(), bus_ ? std::strerror(-result) : why_no_bus_);
}

int LoginBus::answered(sd_bus_message* message, void* request, sd_bus_error*) {
  LoginBus& bus = static_cast<Request*>(request)->bus;
  const auto place =
      std::ranges::find(bus.requests_, request, [](const Request& each) -> const void* { return &each; });
  int lock = -1;  // owned by the message
  if (const sd_bus_error* error = sd_bus_message_get_error(message)) {
    bus.answer(place, FileDescriptor(), error->message != nullptr ? error->message : error->name);
  } else if (const int result = sd_bus_message_read(message, "h", &lock); result < 0) {
    bus.answer(place, FileDescriptor(), std::strerror(-result));
  } else {
    bus.answer(place, FileDescriptor(::fcntl(lock, F_DUPFD_CLOEXEC, 3)), {});
  }
  return 0;
}

void LoginBus::answer(std::list<Request>::iterator request, FileDescriptor lock, const std::string& refusal) {
  // A posted function must be copyable; a descriptor is not.
  auto shared = std::make_shared<FileDescriptor>(std::move(lock));
  mailbox_.post([taken = std::move(request->taken), shared, refusal] { taken(std::move(*shared), refusal); });
  requests_.erase(request);
}

}  // namespace contourd
