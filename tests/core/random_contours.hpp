// Contours for the tests, and the plain way to relate points of the plane to them.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "tests/random_shapes.hpp"

namespace contourd::testing {

using Loop = std::vector<Point>;

inline Contours contours_from(const std::vector<Loop>& loops) {
  Contours contours;
  for (const Loop& loop : loops) {
    contours.loops.push_back(
        {static_cast<std::uint32_t>(contours.points.size()), static_cast<std::uint32_t>(loop.size())});
    contours.points.insert(contours.points.end(), loop.begin(), loop.end());
  }
  return contours;
}

inline Contours one_loop(Loop points) {
  return contours_from({std::move(points)});
}

// Returns a rectangle, counter-clockwise.
inline Loop rectangle(double left, double low, double right, double high) {
  return {{left, low}, {right, low}, {right, high}, {left, high}};
}

// Returns a regular polygon around a centre, counter-clockwise.
inline Loop circle(Point center, double radius, int corners) {
  Loop loop;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    loop.push_back({center.x + radius * std::cos(angle), center.y + radius * std::sin(angle)});
  }
  return loop;
}

inline Loop turned(Loop loop) {
  std::ranges::reverse(loop);
  return loop;
}

inline Loop loop_of(const Polygon& polygon) {
  Loop loop;
  for (const PixelPoint& p : polygon)
    loop.push_back({p.x, p.y});
  return loop;
}

template <typename Call>
void for_each_side(const Contours& contours, Call call) {
  for (const ContourLoop& loop : contours.loops) {
    const auto points = contours.points_of(loop);
    for (std::size_t i = 0; i < points.size(); ++i)
      call(points[i], points[(i + 1) % points.size()]);
  }
}

inline int winding_around(const Contours& contours, Point p) {
  int winding = 0;
  for_each_side(contours, [&](Point a, Point b) {
    if ((a.y <= p.y) == (b.y <= p.y)) return;
    const double x = a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
    if (x < p.x) winding += b.y < a.y ? 1 : -1;
  });
  return winding;
}

inline double distance_to_side(Point a, Point b, Point p) {
  const double x = b.x - a.x, y = b.y - a.y, length2 = x * x + y * y;
  const double along =
      length2 > 0 ? std::clamp(((p.x - a.x) * x + (p.y - a.y) * y) / length2, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - along * x, p.y - a.y - along * y);
}

inline double distance_to_sides(const Contours& contours, Point p) {
  double nearest = std::numeric_limits<double>::infinity();
  for_each_side(contours, [&](Point a, Point b) { nearest = std::min(nearest, distance_to_side(a, b, p)); });
  return nearest;
}

}  // namespace contourd::testing
