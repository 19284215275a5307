// An ellipse in pixels, and where the rows' centre lines enter and leave it. By wider vectors where the
// processor has them: the same numbers on every one. Pure functions, thread-safe.
#pragma once

#include <cstdint>
#include <span>

#include "core/contour/conic_cut.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// At the height Y below its middle a row's centre line is inside from lean Y - sqrt(flat - bend Y^2) to
// lean Y + the same, right of the middle.
struct PixelEllipse {
  PixelPoint middle;
  double lean, flat, bend;
  double reach_x, reach_y;  // at most, to both sides
};

// REQUIRES: cut.whole. Neither flat nor bend is above 0 where it has no size.
[[nodiscard]] PixelEllipse pixel_ellipse(const ConicCut& cut, const PixelMap& map);

// Of rows that the ellipse reaches: the first column whose centre is inside, and the one after the last; the
// same where there is none. Of the row `top + i` these are first[i] and end[i].
struct RowEnds {
  std::span<std::int32_t> first, end;
};
// `width`: the display's, in pixels. REQUIRES: first and end are as long as each other.
void find_row_ends(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);
// The same by what every processor has.
void find_row_ends_baseline(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);

}  // namespace contourd
