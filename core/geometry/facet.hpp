// STL facets as their file has them: three vertices in millimetres, counter-clockwise seen from outside.
// Values; thread-safe as any value is.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace contourd {

struct Vertex {
  float x, y, z;
  bool operator==(const Vertex&) const = default;
};

// A facet's normal is not kept: files get it wrong, the winding tells.
struct Facet {
  std::array<Vertex, 3> vertices;
};
static_assert(sizeof(Facet) == 36);
// A model has fewer: the numbers of their sides have 32 bits.
inline constexpr std::size_t kMaxFacets = std::size_t{1} << 30;

[[nodiscard]] inline bool is_finite(const Facet& facet) {
  // A sum of finite floats in double stays finite; one NaN or infinity makes it not.
  double sum = 0;
  for (const Vertex& v : facet.vertices) {
    sum += static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
  }
  return std::isfinite(sum);
}

// From a facet's lowest vertex to its highest, in millimetres.
struct HeightRange {
  float low, high;
  bool operator==(const HeightRange&) const = default;
};

[[nodiscard]] inline HeightRange heights_of(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  return {std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z})};
}

// A point of a slicing plane, in millimetres.
struct Point {
  double x, y;
  bool operator==(const Point&) const = default;
};

// An axis-aligned box around vertices, in millimetres. Empty (min > max) until something is added.
struct Bounds {
  double min_x = std::numeric_limits<double>::infinity();
  double min_y = std::numeric_limits<double>::infinity();
  double min_z = std::numeric_limits<double>::infinity();
  double max_x = -std::numeric_limits<double>::infinity();
  double max_y = -std::numeric_limits<double>::infinity();
  double max_z = -std::numeric_limits<double>::infinity();

  [[nodiscard]] bool empty() const { return min_x > max_x; }
  [[nodiscard]] double size_x() const { return empty() ? 0.0 : max_x - min_x; }
  [[nodiscard]] double size_y() const { return empty() ? 0.0 : max_y - min_y; }
  [[nodiscard]] double size_z() const { return empty() ? 0.0 : max_z - min_z; }
  [[nodiscard]] Point center() const { return {(min_x + max_x) / 2, (min_y + max_y) / 2}; }
};

[[nodiscard]] inline Bounds bounds_of(std::span<const Facet> facets) {
  // Kept in float: exact, since the coordinates are floats, and half the work.
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Vertex low{kInfinity, kInfinity, kInfinity};
  Vertex high{-kInfinity, -kInfinity, -kInfinity};
  for (const Facet& facet : facets) {
    for (const Vertex& v : facet.vertices) {
      low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
      high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
    }
  }
  return {low.x, low.y, low.z, high.x, high.y, high.z};
}

}  // namespace contourd
