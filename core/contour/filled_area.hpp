// The area that a section's loops enclose under the non-zero winding rule: overlapping solids count once,
// cavities not. Thread-safe (no shared state).
#pragma once

#include "core/contour/contour_loops.hpp"

namespace contourd {

// Returns the area in square millimetres, exact but for rounding: where loops meet, to 2^-30 of their width.
// The cost grows as n log n in the number of sides and of their crossings. Beyond a million sides (a soup of
// facets, no solid), which take 150 MB, the area is an estimate.
[[nodiscard]] double filled_area_mm2(const Contours& contours);

}  // namespace contourd
