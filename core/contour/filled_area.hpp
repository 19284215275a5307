// The area that a section's loops enclose under the non-zero winding rule: overlapping solids count once,
// cavities not. Thread-safe (no shared state).
#pragma once

#include "core/contour/contour_loops.hpp"

namespace contourd {

// In square millimetres; exact but for rounding: where loops meet, to 2^-30 of their width. The cost grows as
// n log n in sides and the places where they cross; with a million of those (a soup of facets, no solid),
// which take 150 MB, it is an estimate.
[[nodiscard]] double filled_area_mm2(const Contours& contours);

}  // namespace contourd
