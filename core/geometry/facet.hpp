// STL facets as they are in the file: three vertices in millimetres, counter-clockwise seen from outside.
// Values; thread-safe as any value is.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
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
  // A float with all bits of its exponent set is infinite or not a number. Comparing bits takes fewer
  // instructions than adding floats.
  constexpr std::uint32_t kExponent = 0x7F80'0000;
  std::uint32_t not_finite = 0;
  for (const std::uint32_t bits : std::bit_cast<std::array<std::uint32_t, 9>>(facet))
    not_finite |= static_cast<std::uint32_t>((bits & kExponent) == kExponent);
  return not_finite == 0;
}

// Returns twice a facet's area, in mm2.
[[nodiscard]] inline double twice_area(const Facet& facet) {
  const auto [a, b, c] = facet.vertices;
  const double ux = static_cast<double>(b.x) - a.x, uy = static_cast<double>(b.y) - a.y;
  const double uz = static_cast<double>(b.z) - a.z, vx = static_cast<double>(c.x) - a.x;
  const double vy = static_cast<double>(c.y) - a.y, vz = static_cast<double>(c.z) - a.z;
  return std::hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx);
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
  // Computed in float: exact, since the coordinates are floats. Four vertices, three vectors of four floats,
  // are compared at a time: a third of the instructions.
  using Floats [[gnu::vector_size(16)]] = float;
  using FourVertices = std::array<Floats, 3>;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr Floats kHighest{kInfinity, kInfinity, kInfinity, kInfinity};
  FourVertices low{kHighest, kHighest, kHighest}, high{-kHighest, -kHighest, -kHighest};
  const auto compare = [&low, &high](const FourVertices& vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = vertices[i] < low[i] ? vertices[i] : low[i];
      high[i] = vertices[i] > high[i] ? vertices[i] : high[i];
    }
  };
  const std::size_t in_fours = facets.size() / 4 * 4;
  for (std::size_t i = 0; i < in_fours; i += 4) {
    std::array<FourVertices, 3> four_facets;
    std::memcpy(&four_facets, &facets[i], sizeof four_facets);
    for (const FourVertices& vertices : four_facets)
      compare(vertices);
  }
  for (const Facet& facet : facets.subspan(in_fours)) {
    const auto& [a, b, c] = facet.vertices;
    const std::array four{a, b, c, c};
    compare(std::bit_cast<FourVertices>(four));
  }
  const auto lows = std::bit_cast<std::array<Vertex, 4>>(low),
             highs = std::bit_cast<std::array<Vertex, 4>>(high);
  Vertex lowest = lows[0], highest = highs[0];
  for (const Vertex& v : lows)
    lowest = {std::min(lowest.x, v.x), std::min(lowest.y, v.y), std::min(lowest.z, v.z)};
  for (const Vertex& v : highs)
    highest = {std::max(highest.x, v.x), std::max(highest.y, v.y), std::max(highest.z, v.z)};
  return {lowest.x, lowest.y, lowest.z, highest.x, highest.y, highest.z};
}

}  // namespace contourd
