// A virtual clock for a fixture, and the ways to let its time pass. Not thread-safe.
#pragma once

#include <functional>

#include "hw/virtual_clock.hpp"

namespace contourd::testing {

struct VirtualTimeFixture {
  // Makes all pending calls.
  void run() {
    while (clock.run_next()) {
    }
  }
  // Lets this time pass and makes the calls that are due, each followed by `after_each`.
  void pass(
      Duration time, const std::function<void()>& after_each = [] {}) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over && clock.run_next())
      after_each();
  }
  [[nodiscard]] Duration now() const { return clock.now().time_since_epoch(); }

  VirtualClock clock;
};

}  // namespace contourd::testing
