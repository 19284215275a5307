#include "core/model/enclosed_volume.hpp"

#include <cmath>

namespace contourd {

EnclosedVolume enclosed_volume(std::span<const Facet> facets, const Bounds& bounds) {
  if (facets.empty()) return {};
  // All in double: differences of floats would be rounded, or overflow.
  const auto [x, y] = bounds.center();
  const double z = (bounds.min_z + bounds.max_z) / 2;
  double six_volumes = 0;
  // Twice the facets' areas as vectors: their sum is 0 if the facets close. Calculated from a point at a
  // distance d, the volume would differ by d times a third of this area.
  double sum_x = 0, sum_y = 0, sum_z = 0;
  for (const Facet& facet : facets) {
    const auto& [a, b, c] = facet.vertices;
    const double ax = a.x, ay = a.y, az = a.z;
    const double ux = b.x - ax, uy = b.y - ay, uz = b.z - az;
    const double vx = c.x - ax, vy = c.y - ay, vz = c.z - az;
    const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    six_volumes += (ax - x) * nx + (ay - y) * ny + (az - z) * nz;
    sum_x += nx;
    sum_y += ny;
    sum_z += nz;
  }
  const double diagonal = std::hypot(bounds.size_x(), bounds.size_y(), bounds.size_z());
  return {six_volumes / 6, std::hypot(sum_x, sum_y, sum_z) * diagonal / 6};
}

}  // namespace contourd
