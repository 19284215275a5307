// A facet's area as a vector, and calculations with such vectors. Pure functions, thread-safe; only + - * and
// the square root, which every machine rounds alike.
#pragma once

#include <cmath>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"

namespace contourd {

[[nodiscard]] inline double dot(const Direction& a, const Direction& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

[[nodiscard]] inline double length_of(const Direction& v) {
  return std::sqrt(dot(v, v));
}

// Returns a vector along the facet's normal, as long as the facet's area in mm2.
[[nodiscard]] inline Direction area_of(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double ax = a.x, ay = a.y, az = a.z;
  const double ux = b.x - ax, uy = b.y - ay, uz = b.z - az;
  const double vx = c.x - ax, vy = c.y - ay, vz = c.z - az;
  return {(uy * vz - uz * vy) / 2, (uz * vx - ux * vz) / 2, (ux * vy - uy * vx) / 2};
}

}  // namespace contourd
