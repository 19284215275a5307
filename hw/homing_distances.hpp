// How far every axis goes while nobody knows where its plate is, real or simulated: in homing, and by hand.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

// Back from the switch before the slow second pass (Klipper's and Prusa's mSLA profiles use 2 to 5 mm).
inline constexpr Nanometers kBackOff{5'000'000};
// A switch that has not triggered after the way to it and this much more never will.
inline constexpr Nanometers kOvertravel{5'000'000};
// By hand, to see which way the plate goes: enough to be seen, less than homing backs off. Where microsteps
// are set wrongly by 16 times it is 32 mm, so the plate belongs into the middle of its travel.
inline constexpr Nanometers kLongestNudge{2'000'000};
// As slow as leaves time to pull a plug.
inline constexpr MillimetersPerSecond kNudgeSpeed{1};

}  // namespace contourd
