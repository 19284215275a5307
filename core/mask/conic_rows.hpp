// The pixels whose centres lie in a conic cut, row by row: for an ellipse straight from its equation, a
// square root a row; of what is cut off at an end, the polygon's (see ConvexRows).
//
// Not thread-safe; allocates only while polygons and the number of ellipses grow.
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

  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, cut by cut.
  template <typename Visit>
  void visit(std::span<const ConicCut> cuts, const PixelMap& map, Visit&& visit) {
    ellipses_.clear();
    for (const ConicCut& cut : cuts) {
      if (cut.whole) {
        ellipses_.push_back(ellipse_of(cut, map));
        continue;
      }
      polygon_.points.clear();
      polygon_.loops.clear();
      append_outline(cut, polygon_);
      if (!polygon_.loops.empty()) polygons_.visit(polygon_.points, map, visit);
    }
    for (const PixelEllipse& ellipse : ellipses_) {
      const RowRange rows = find_ends(ellipse);
      for (std::int32_t row = rows.first; row < rows.end; ++row) {
        const auto at = static_cast<std::size_t>(row - rows.first);
        if (first_[at] < end_[at]) visit(row, first_[at], end_[at]);
      }
    }
  }
  // The same for a convex polygon.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    polygons_.visit(corners, map, visit);
  }

 private:
  // In pixels: at the height Y below its middle a row's centre line is inside from lean Y - sqrt(flat -
  // bend Y^2) to lean Y + the same, right of the middle. It reaches as far above its middle as below.
  struct PixelEllipse {
    PixelPoint middle;
    double lean, flat, bend, reach;
  };
  struct RowRange {
    std::int32_t first, end;
  };
  [[nodiscard]] static PixelEllipse ellipse_of(const ConicCut& cut, const PixelMap& map);
  [[nodiscard]] RowRange find_ends(const PixelEllipse& ellipse);

  double width_, height_;
  std::vector<std::int32_t> first_, end_;  // of each row of an ellipse
  std::vector<PixelEllipse> ellipses_;     // all before the first one's rows: each waits for no other's
  ConvexRows polygons_;
  Contours polygon_;
};

}  // namespace contourd
