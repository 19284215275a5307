// The wake-up latency of a thread like the step thread, measured on this computer without making steps, and
// the step rate that the latency sustains.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hw/clock.hpp"

namespace contourd {

struct WakeUpLatency {
  std::uint64_t count = 0;
  Duration p99{};    // 99 of 100 wake-ups came within this time
  Duration worst{};  // the longest
  // A sentence for each request of the thread that the system refused.
  std::vector<std::string> refusals{};

  // Returns the step rate that this latency sustains, in steps/s: 99 steps of 100 come within half an
  // interval, and none is so late that the motor has come to rest. At most `most`; 0 if no rate is sustained.
  [[nodiscard]] double sustainable_rate(double most) const;
};

// Measures `rate` wake-ups per second, with absolute deadlines and with SCHED_FIFO `priority` if that is
// allowed. Blocks for `lasting`. Throws std::system_error if no thread can be created.
[[nodiscard]] WakeUpLatency measure_wake_up_latency(double rate, int priority, Duration lasting);

}  // namespace contourd
