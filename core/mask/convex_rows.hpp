// Finds the pixels whose centres lie in a convex polygon, row by row. A centre on a side is inside if the
// polygon lies right of the side, or below it for a level side, as for AntiAliasing::Off.
//
// Not thread-safe; allocates in its constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/geometry/facet.hpp"
#include "core/mask/pixel_centers.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

class ConvexRows {
 public:
  ConvexRows(Pixels width, Pixels height);

  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, from the top. The
  // polygon may lie anywhere, and run either way around. REQUIRES: at least one corner.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    expects(!corners.empty(), "a polygon has corners");
    const RowRange rows = find_ends(corners, map);
    for (std::int32_t row = rows.first; row < rows.end; ++row) {
      const Ends& ends = ends_[static_cast<std::size_t>(row)];
      const std::int32_t first = centers_before(ends.left, width_), end = centers_before(ends.right, width_);
      if (first < end) visit(row, first, end);
    }
  }

 private:
  struct RowRange {
    std::int32_t first, end;
  };
  // The columns where a row's centre line enters and leaves the polygon.
  struct Ends {
    double left = std::numeric_limits<double>::infinity();
    double right = -std::numeric_limits<double>::infinity();
  };

  [[nodiscard]] RowRange find_ends(std::span<const Point> corners, const PixelMap& map);
  void add_side(PixelPoint from, PixelPoint to);

  std::int32_t width_, height_;
  std::vector<Ends> ends_;  // by row
};

}  // namespace contourd
