#include "core/mask/convex_rows.hpp"

#include <algorithm>
#include <utility>

namespace contourd {

ConvexRows::ConvexRows(Pixels width, Pixels height)
    : width_(width.count()), height_(height.count()), ends_(static_cast<std::size_t>(height.count())) {}

ConvexRows::RowRange ConvexRows::find_ends(std::span<const Point> corners, const PixelMap& map) {
  double top = std::numeric_limits<double>::infinity(), bottom = -top;
  for (const Point& corner : corners) {
    const double y = map.to_pixels(corner).y;
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  const RowRange rows{centers_before(top, height_), centers_before(bottom, height_)};
  std::fill(ends_.begin() + rows.first, ends_.begin() + rows.end, Ends{});
  PixelPoint last = map.to_pixels(corners.back());
  for (const Point& corner : corners) {
    const PixelPoint next = map.to_pixels(corner);
    add_side(last, next);
    last = next;
  }
  return rows;
}

// Widens the rows that the side crosses. If rounding makes the polygon slightly non-convex, the outermost
// sides count.
void ConvexRows::add_side(PixelPoint from, PixelPoint to) {
  if (to.y < from.y) std::swap(from, to);
  const std::int32_t end = centers_before(to.y, height_);
  std::int32_t row = centers_before(from.y, height_);
  if (row == end) return;
  const double slope = (to.x - from.x) / (to.y - from.y);
  for (; row < end; ++row) {
    Ends& ends = ends_[static_cast<std::size_t>(row)];
    const double x = from.x + (row + 0.5 - from.y) * slope;
    ends.left = std::min(ends.left, x);
    ends.right = std::max(ends.right, x);
  }
}

}  // namespace contourd
