// STL facets as they are in the file: three vertices in millimetres, counter-clockwise seen from outside.
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

// The normal is not stored: files get it wrong, and the order of the vertices defines it.
struct Facet {
  std::array<Vertex, 3> vertices;
};
static_assert(sizeof(Facet) == 36);
// A model has fewer facets than this, so that the numbers of their sides fit into 32 bits.
inline constexpr std::size_t kMaxFacets = std::size_t{1} << 30;

[[nodiscard]] inline bool is_finite(const Facet& facet) {
  // A sum of finite floats in double stays finite; a single NaN or infinity makes it NaN or infinite.
  double sum = 0;
  for (const Vertex& v : facet.vertices) {
    sum += static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
  }
  return std::isfinite(sum);
}

// The heights of a facet's lowest and highest vertex, in millimetres.
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

// An axis-aligned box around vertices, in millimetres. A box around no vertex is empty (min > max).
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
  // Computed in float: exact, since the coordinates are floats, and half the work.
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
