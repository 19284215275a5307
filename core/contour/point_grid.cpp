#include "core/contour/point_grid.hpp"

#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {

PointGrid::Cell PointGrid::cell_of(const Point& point, std::uint32_t number) const {
  return {std::floor(point.y / cell_mm_), std::floor(point.x / cell_mm_), number};
}

void PointGrid::sort(std::span<const Point> points, std::span<const std::uint32_t> chosen, double reach) {
  expects(reach > 0, "the reach is positive");
  cell_mm_ = reach;
  cells_.clear();
  for (const std::uint32_t number : chosen)
    cells_.push_back(cell_of(points[number], number));
  std::sort(cells_.begin(), cells_.end());
}

}  // namespace contourd
