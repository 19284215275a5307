// Monotonic time, and calls scheduled for a time. Everything that waits in contourd waits through a Clock, so
// that the simulated printer can run faster than real time and tests need not sleep. Single-threaded: used
// from the event loop's thread only.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <utility>

#include "hw/interface.hpp"

namespace contourd {

using Duration = std::chrono::nanoseconds;
// CLOCK_MONOTONIC, or a simulated clock's own time. Never the wall clock, which jumps.
using TimePoint = std::chrono::time_point<std::chrono::steady_clock, Duration>;

[[nodiscard]] constexpr double in_seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}
[[nodiscard]] constexpr double in_ms(Duration duration) {
  return std::chrono::duration<double, std::milli>(duration).count();
}

// A pending call; destroying it cancels the call. Safe to destroy from inside that call.
class Timer : public Interface {};

class Clock : public Interface {
 public:
  [[nodiscard]] virtual TimePoint now() const = 0;

  // True if time passes only from call to call, so that a thread of this process takes none of it.
  [[nodiscard]] virtual bool skips_waiting() const { return false; }

  // Calls `call` once, from the event loop, at `when` or as soon after as the loop gets to it; never from
  // inside call_at itself. Calls due at the same time run in the order they were asked for.
  [[nodiscard]] virtual std::unique_ptr<Timer> call_at(TimePoint when, std::function<void()> call) = 0;

  [[nodiscard]] std::unique_ptr<Timer> call_after(Duration delay, std::function<void()> call) {
    return call_at(now() + delay, std::move(call));
  }
};

}  // namespace contourd
