#include "hw/gpio/axis_threads.hpp"

#include <poll.h>
#include <time.h>

#include <algorithm>

namespace contourd {
namespace {

timespec time_until(TimePoint when) noexcept {
  const Duration left = std::max(when - monotonic_now(), Duration{0});
  return {static_cast<time_t>(left / std::chrono::seconds{1}),
          static_cast<long>((left % std::chrono::seconds{1}).count())};
}

}  // namespace

InputThread::InputThread(AxisInputs& inputs, int priority)
    : inputs_(inputs),
      thread_(
          "contourd-inputs", priority,
          [](void* self) -> void* {
            static_cast<InputThread*>(self)->run();
            return nullptr;
          },
          this) {}

InputThread::~InputThread() {
  quit_ = true;
  inputs_.work().signal();
}

void InputThread::run() noexcept {
  auto descriptors = inputs_.descriptors();
  while (!quit_) {
    const auto next = inputs_.serve();
    const timespec left = next ? time_until(*next) : timespec{};
    if (ppoll(descriptors.data(), descriptors.size(), next ? &left : nullptr, nullptr) <= 0) continue;
    for (pollfd& waited : descriptors) {
      if ((waited.revents & (POLLERR | POLLHUP | POLLNVAL)) == 0) continue;
      waited.fd = -1;
      inputs_.lose();
    }
  }
}

std::vector<std::string> RealtimeAxisThreads::refusals() const {
  std::vector<std::string> all = steps_.refusals();
  all.insert(all.end(), inputs_.refusals().begin(), inputs_.refusals().end());
  return all;
}

}  // namespace contourd
