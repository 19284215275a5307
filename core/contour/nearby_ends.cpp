#include "core/contour/nearby_ends.hpp"

#include <cmath>

namespace contourd {

NearbyEnds::Cell NearbyEnds::cell_of(const Point& point, std::uint32_t number) const {
  return {std::floor(point.y / cell_mm_), std::floor(point.x / cell_mm_), number};
}

void NearbyEnds::sort(std::span<const Point> points, std::span<const std::uint32_t> chosen, double reach) {
  cell_mm_ = reach;
  cells_.clear();
  for (const std::uint32_t number : chosen)
    cells_.push_back(cell_of(points[number], number));
  std::sort(cells_.begin(), cells_.end());
}

}  // namespace contourd
