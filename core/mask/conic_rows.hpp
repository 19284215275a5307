// Finds the pixels whose centres lie in a conic cut, row by row. For a whole ellipse they come straight from
// its equation, with a square root for each row; for a cut with ends cut off they are those of its polygon
// (see ConvexRows).
//
// Not thread-safe; allocates only while polygons grow.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/conic_cut.hpp"
#include "core/mask/convex_rows.hpp"
#include "core/mask/pixel_ellipse.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// An ellipse's pixels: in row `top + i` the columns [first[i], end[i]), none if end[i] <= first[i]. All of
// them lie in [left, right).
struct EllipseRows {
  std::int32_t top;
  std::span<const std::int32_t> first, end;
  std::int32_t left, right;
};

class ConicRows {
 public:
  ConicRows(Pixels width, Pixels height);

  // Returns the rows of a whole cut (see pixel_ellipse()). Valid until the next call.
  [[nodiscard]] EllipseRows ellipse(const ConicCut& cut, const PixelMap& map);
  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, from the top, of a
  // cut that is not whole.
  template <typename Visit>
  void visit(const ConicCut& cut, const PixelMap& map, Visit&& visit) {
    polygon_.points.clear();
    polygon_.loops.clear();
    append_outline(cut, polygon_);
    if (!polygon_.loops.empty()) polygons_.visit(polygon_.points, map, visit);
  }
  // Calls `visit` in the same way for a convex polygon.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    polygons_.visit(corners, map, visit);
  }

 private:
  std::int32_t width_, height_;
  std::vector<std::int32_t> first_, end_;  // by row of an ellipse
  ConvexRows polygons_;
  Contours polygon_;
};

}  // namespace contourd
