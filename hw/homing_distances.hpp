// How far every axis goes while it homes, real or simulated.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

// Back from the switch before the slow second pass (Klipper's and Prusa's mSLA profiles use 2 to 5 mm).
inline constexpr Nanometers kBackOff{5'000'000};
// A switch that has not triggered after the way to it and this much more never will.
inline constexpr Nanometers kOvertravel{5'000'000};

}  // namespace contourd
