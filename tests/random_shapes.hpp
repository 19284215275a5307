// Random numbers and shapes for property tests. Use only within rc::check.
#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/mask/pixel_map.hpp"
#include "tests/models/models.hpp"

namespace contourd::testing {

// Draws a whole number in [low, high], from the whole range from the first test case on.
inline std::int64_t draw(std::int64_t low, std::int64_t high) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange<std::int64_t>(low, high + 1));
}

// The step of the numbers of draw_real(), 2^-22: fine enough that a side hardly ever meets the exact centre
// of a pixel, coarse enough that products of differences are exact in 64 bits.
inline constexpr double kGrid = 1.0 / (1 << 22);

inline double draw_real(double low, double high) {
  return static_cast<double>(draw(std::llround(low / kGrid), std::llround(high / kGrid))) * kGrid;
}

inline float draw_float(double low, double high) {
  return static_cast<float>(draw_real(low, high));
}

inline Vertex draw_vertex(double reach) {
  return {draw_float(-reach, reach), draw_float(-reach, reach), draw_float(-reach, reach)};
}

inline Facet draw_facet(double reach) {
  return {{draw_vertex(reach), draw_vertex(reach), draw_vertex(reach)}};
}

using Polygon = std::vector<PixelPoint>;

// Draws any polygon; most of them cross themselves.
inline Polygon draw_polygon(double low_x, double high_x, double low_y, double high_y) {
  Polygon polygon(static_cast<std::size_t>(draw(3, 9)));
  for (PixelPoint& point : polygon)
    point = {draw_real(low_x, high_x), draw_real(low_y, high_y)};
  return polygon;
}

// Draws a polygon that does not cross itself: around its centre, at radii between `smallest` and `largest`.
inline Polygon draw_star(PixelPoint center, double smallest, double largest) {
  const auto corners = draw(3, 24);
  Polygon polygon;
  for (std::int64_t i = 0; i < corners; ++i) {
    const double angle =
        2 * std::numbers::pi * (static_cast<double>(i) + draw_real(0, 0.9)) / static_cast<double>(corners);
    const double radius = draw_real(smallest, largest);
    polygon.push_back({center.x + radius * std::cos(angle), center.y + radius * std::sin(angle)});
  }
  return polygon;
}

// Draws a closed mesh of one to four balls, merged where they come near each other.
inline models::Facets draw_blobs(int cells) {
  struct Ball {
    double x, y, z, radius;
  };
  std::vector<Ball> balls(static_cast<std::size_t>(draw(1, 4)));
  for (Ball& ball : balls)
    ball = {draw_real(-5, 5), draw_real(-5, 5), draw_real(-5, 5), draw_real(1, 4)};
  return models::isosurface(
      [&](double x, double y, double z) {
        double nearness = 0;
        for (const Ball& b : balls) {
          nearness += std::exp2(b.radius - std::hypot(x - b.x, y - b.y, z - b.z));
        }
        return 1.0 - nearness;
      },
      12.0, cells);
}

}  // namespace contourd::testing
