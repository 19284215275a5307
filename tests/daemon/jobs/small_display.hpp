// A display that is small enough for fast masks: 64 x 48 pixels of 0.1 mm.
#pragma once

#include "core/mask/pixel_map.hpp"

namespace contourd::testing {

inline constexpr DisplayGeometry kSmallDisplay{Pixels{64}, Pixels{48}, Micrometers{100.0}};

}  // namespace contourd::testing
