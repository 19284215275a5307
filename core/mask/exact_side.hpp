// Finds the side of a line that a point lies on, without any rounding. Thread-safe (no shared state).
#pragma once

#include "core/mask/pixel_map.hpp"

namespace contourd {

// Returns 1 if `point` lies on the side of the line from a to b to which a quarter turn from x to y leads, -1
// if on the other side, 0 if on the line: the exact sign of (b - a) x (point - a), by Shewchuk's expansions
// (Adaptive Precision Floating-Point Arithmetic, 1997). REQUIRES: coordinates below 1e100.
[[nodiscard]] int side_of(PixelPoint a, PixelPoint b, PixelPoint point);

}  // namespace contourd
