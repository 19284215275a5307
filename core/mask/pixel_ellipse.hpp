// An ellipse in pixels, and the columns where the rows' centre lines enter and leave it. Uses wider vectors
// if the processor has them, with the same results on every processor. Pure functions, thread-safe.
#pragma once

#include <cstdint>
#include <span>

#include "core/contour/conic_cut.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// An ellipse: at the height Y below its middle, a row's centre line is inside from lean Y - sqrt(flat - bend
// Y^2) to lean Y + sqrt(flat - bend Y^2), right of the middle.
struct PixelEllipse {
  PixelPoint middle;
  double lean, flat, bend;
  double reach_x, reach_y;  // largest extent to both sides
};

// Returns a whole cut as an ellipse; if it has no size, neither flat nor bend is above 0. REQUIRES:
// cut.whole.
[[nodiscard]] PixelEllipse pixel_ellipse(const ConicCut& cut, const PixelMap& map);

// The row ends of an ellipse: for row `top + i`, first[i] is the first column whose centre is inside, and
// end[i] the column after the last; equal if there is none.
struct RowEnds {
  std::span<std::int32_t> first, end;
};
// Fills `ends` for the rows from `top` on. `width`: the display's, in pixels. REQUIRES: first and end have
// the same length.
void find_row_ends(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);
// Does the same with the instructions that every processor has.
void find_row_ends_baseline(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);

}  // namespace contourd
