// Timeouts for the motions of an axis. An axis reports its own failures; the timeouts catch an axis that does
// not answer at all.
#pragma once

#include <chrono>

#include "hw/z_axis.hpp"

namespace contourd {

// Time for coming to a standstill. A move gets its expected time, a tenth more, and this (Ember's figure).
inline constexpr Duration kStopTimeout = std::chrono::seconds{15};

[[nodiscard]] inline Duration move_timeout(const ZAxis& axis, Nanometers distance,
                                           MillimetersPerSecond speed) {
  return axis.move_duration(distance, speed) * 11 / 10 + kStopTimeout;
}

// Returns the timeout for homing: twice the time for the travel and 25 mm, which is more than any homing
// takes. Homing covers the travel at most once, and a few millimetres beyond it, back off the switch and to
// it again, partly at half the speed.
[[nodiscard]] inline Duration homing_timeout(const ZAxis& axis, MillimetersPerSecond speed) {
  constexpr Nanometers kExtra{25'000'000};
  return axis.move_duration(axis.travel() + kExtra, speed) * 2 + kStopTimeout;
}

}  // namespace contourd
