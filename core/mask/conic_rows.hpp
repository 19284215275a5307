// The pixels whose centres lie in a conic cut, row by row: for an ellipse straight from its equation, a
// square root a row; of what is cut off at an end, the polygon's (see ConvexRows).
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

// An ellipse's pixels: of the row `top + i` those from first[i] until end[i], none where that is no more.
// All of them lie from `left` until `right`.
struct EllipseRows {
  std::int32_t top;
  std::span<const std::int32_t> first, end;
  std::int32_t left, right;
};

class ConicRows {
 public:
  ConicRows(Pixels width, Pixels height);

  // Of a whole cut (see pixel_ellipse()). Valid until the next call.
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
  // The same for a convex polygon.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    polygons_.visit(corners, map, visit);
  }

 private:
  std::int32_t width_, height_;
  std::vector<std::int32_t> first_, end_;  // of each row of an ellipse
  ConvexRows polygons_;
  Contours polygon_;
};

}  // namespace contourd
