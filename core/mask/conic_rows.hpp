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
#include "core/mask/pixel_map.hpp"

namespace contourd {

class ConicRows {
 public:
  ConicRows(Pixels width, Pixels height);

  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, from the top.
  template <typename Visit>
  void visit(const ConicCut& cut, const PixelMap& map, Visit&& visit) {
    if (!cut.whole) {
      polygon_.points.clear();
      polygon_.loops.clear();
      append_outline(cut, polygon_);
      if (!polygon_.loops.empty()) polygons_.visit(polygon_.points, map, visit);
      return;
    }
    const RowRange rows = find_ends(cut, map);
    for (std::int32_t row = rows.first; row < rows.end; ++row) {
      const auto at = static_cast<std::size_t>(row - rows.first);
      if (first_[at] < end_[at]) visit(row, first_[at], end_[at]);
    }
  }
  // The same for a convex polygon.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    polygons_.visit(corners, map, visit);
  }

 private:
  struct RowRange {
    std::int32_t first, end;
  };
  [[nodiscard]] RowRange find_ends(const ConicCut& cut, const PixelMap& map);

  double width_, height_;
  std::vector<std::int32_t> first_, end_;  // of each row of an ellipse
  ConvexRows polygons_;
  Contours polygon_;
};

}  // namespace contourd
