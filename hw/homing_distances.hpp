// Distances that an axis, real or simulated, moves while its position is unknown: in homing, and by hand.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

// Distance by which homing backs off from the switch before the slow second pass (Klipper's and Prusa's mSLA
// profiles use 2 to 5 mm).
inline constexpr Nanometers kBackOff{5'000'000};
// Distance past the full travel after which homing gives up on a switch that has not triggered.
inline constexpr Nanometers kOvertravel{5'000'000};
// Longest move by hand, made to see which way the plate goes: far enough to be seen, less than homing backs
// off. With microsteps misconfigured by a factor of 16 the plate moves 32 mm, so it belongs in the middle of
// its travel.
inline constexpr Nanometers kLongestNudge{2'000'000};
// Speed of a move by hand: slow enough to leave time to pull the plug.
inline constexpr MillimetersPerSecond kNudgeSpeed{1};

}  // namespace contourd
