// A straight segment above the plate and the geometry that supports need of it. Values; thread-safe as any
// value is.
#pragma once

#include <array>
#include <cmath>

#include "core/support/support_contact.hpp"

namespace contourd {

inline constexpr double kSin45 = 0.70710678118654757;  // equal to the cosine
// Horizontal directions of length 1, 45 degrees apart.
inline constexpr std::array<Point, 8> kAround{{{1, 0},
                                               {kSin45, kSin45},
                                               {0, 1},
                                               {-kSin45, kSin45},
                                               {-1, 0},
                                               {-kSin45, -kSin45},
                                               {0, -1},
                                               {kSin45, -kSin45}}};

// Returns the horizontal distance between two points, in millimetres.
[[nodiscard]] inline double level_distance(const PlatePoint& a, const PlatePoint& b) {
  const double x = b.x - a.x, y = b.y - a.y;
  return std::sqrt(x * x + y * y);
}

[[nodiscard]] inline PlatePoint moved(const PlatePoint& at, const Direction& direction, double by_mm) {
  return {at.x + direction.x * by_mm, at.y + direction.y * by_mm, at.z + direction.z * by_mm};
}

struct PlateSegment {
  PlatePoint from, to;

  [[nodiscard]] double length() const {
    const double x = to.x - from.x, y = to.y - from.y, z = to.z - from.z;
    return std::sqrt(x * x + y * y + z * z);
  }
  // Returns the point at `part` of the segment's length: 0 is `from`, 1 is `to`.
  [[nodiscard]] PlatePoint at(double part) const {
    return {from.x + part * (to.x - from.x), from.y + part * (to.y - from.y),
            from.z + part * (to.z - from.z)};
  }
  // True if the segment leads down at 45 degrees or steeper, within a nanometre.
  [[nodiscard]] bool leads_down() const {
    const double x = to.x - from.x, y = to.y - from.y, down = from.z - to.z + 1e-6;
    return down >= 0 && x * x + y * y <= down * down;
  }
};

}  // namespace contourd
