// How late a thread like the one that makes the steps wakes on this computer, measured without a step: what
// speed it keeps.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hw/clock.hpp"

namespace contourd {

struct WakeUps {
  std::uint64_t count = 0;
  Duration p99{};    // 99 of 100 came within it
  Duration worst{};  // of all
  // A sentence for each thing that the system refused the thread.
  std::vector<std::string> refusals{};

  // Steps a second that are kept with such wake-ups: 99 steps of 100 come within half an interval, and none
  // so late that the motor has come to rest. At most `most`; 0 for none.
  [[nodiscard]] double kept_rate(double most) const;
};

// Wakes `rate` times a second, by absolute deadlines and with SCHED_FIFO `priority` where that is allowed.
// Blocks for `lasting`. Throws std::system_error when there can be no thread.
[[nodiscard]] WakeUps measure_wake_ups(double rate, int priority, Duration lasting);

}  // namespace contourd
