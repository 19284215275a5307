// The area that a section's loops enclose under the non-zero winding rule: overlapping solids count once,
// cavities not. Thread-safe (no shared state).
#pragma once

#include "core/contour_loops.hpp"

namespace contourd {

// In square millimetres; exact but for rounding. For inspection, not for every layer: the cost is in
// proportion to the number of sides times the number of sides that a horizontal line crosses, and crossing
// sides cost extra. Where that would take more than some seconds (a soup of facets, no solid), an estimate.
[[nodiscard]] double filled_area_mm2(const Contours& contours);

}  // namespace contourd
