// The wake-up latency of a thread like the one that makes the steps, measured on this computer without a
// step, and the step rate that it sustains.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hw/clock.hpp"

namespace contourd {

struct WakeUpLatency {
  std::uint64_t count = 0;
  Duration p99{};    // 99 of 100 came within it
  Duration worst{};  // of all
  // A sentence for each thing that the system refused the thread.
  std::vector<std::string> refusals{};

  // The step rate that this latency sustains, in steps/s: 99 steps of 100 come within half an interval, and
  // none so late that the motor has come to rest. At most `most`; 0 for none.
  [[nodiscard]] double sustainable_rate(double most) const;
};

// Wakes `rate` times a second, by absolute deadlines and with SCHED_FIFO `priority` where that is allowed.
// Blocks for `lasting`. Throws std::system_error when there can be no thread.
[[nodiscard]] WakeUpLatency measure_wake_up_latency(double rate, int priority, Duration lasting);

}  // namespace contourd
