// How long a motion may take before its axis counts as one that does not answer. An axis tells by itself when
// something is wrong; this is for the day when it does not.
#pragma once

#include <chrono>

#include "hw/z_axis.hpp"

namespace contourd {

// To come to a standstill. A motion has its expected time and a tenth, plus this (Ember's figure).
inline constexpr Duration kStopTimeout = std::chrono::seconds{15};

[[nodiscard]] inline Duration move_timeout(const ZAxis& axis, Nanometers distance,
                                           MillimetersPerSecond speed) {
  return axis.move_duration(distance, speed) * 11 / 10 + kStopTimeout;
}

// The travel once, and some millimetres beside it, beyond it, back off the switch and to it again, of which a
// part at half the speed: twice is more than any homing takes.
[[nodiscard]] inline Duration homing_timeout(const ZAxis& axis, MillimetersPerSecond speed) {
  constexpr Nanometers kBeside{25'000'000};
  return axis.move_duration(axis.travel() + kBeside, speed) * 2 + kStopTimeout;
}

}  // namespace contourd
