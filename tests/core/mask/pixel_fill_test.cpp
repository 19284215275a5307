#include "core/mask/pixel_fill.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mask/pixel_map.hpp"
#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

// Sides and crossings of polygons in the pixel at (0, 0), and the part of it that they fill.
struct CutPolygons {
  std::vector<PixelSide> sides;
  std::vector<EdgeCrossing> crossings;
  double mean = 0, filled = 0;

  explicit CutPolygons(const std::vector<Polygon>& polygons) {
    for (const Polygon& polygon : polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i)
        add(polygon[i], polygon[(i + 1) % polygon.size()]);
    }
    constexpr int kLines = 2000;
    for (int line = 0; line < kLines; ++line)
      add_line(polygons, (line + 0.5) / kLines, 1.0 / kLines);
  }

  void add(PixelPoint from, PixelPoint to) {
    if ((from.x < 0) != (to.x < 0)) {
      const double y = from.y + (to.y - from.y) * (from.x / (from.x - to.x));
      if (0 <= y && y < 1) crossings.push_back({y, from.x < 0 ? -1 : 1});
    }
    const PixelPoint upper = from.y < to.y ? from : to, lower = from.y < to.y ? to : from;
    if (upper.y == lower.y) return;
    const double slope = (lower.x - upper.x) / (lower.y - upper.y);
    double top = std::max(0.0, upper.y), bottom = std::min(1.0, lower.y);
    if (slope != 0) {  // the heights at which the side is between the left and the right edge
      const auto [first, last] = std::minmax({upper.y - upper.x / slope, upper.y + (1 - upper.x) / slope});
      top = std::max(top, first);
      bottom = std::min(bottom, last);
    } else if (upper.x < 0 || upper.x > 1) {
      return;
    }
    if (top < bottom)
      sides.push_back({upper.x + slope * (top - upper.y), top, bottom, slope, from.y < to.y ? 1 : -1});
  }

  void add_line(const std::vector<Polygon>& polygons, double y, double height) {
    std::vector<std::pair<double, int>> hits;
    for (const Polygon& polygon : polygons) {
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const PixelPoint a = polygon[i], b = polygon[(i + 1) % polygon.size()];
        if ((a.y < y) != (b.y < y))
          hits.emplace_back(std::clamp(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)), 0.0, 1.0),
                            a.y < b.y ? 1 : -1);
      }
    }
    std::ranges::sort(hits);
    int winding = 0;
    double x = 0;
    for (const auto& [next_x, sign] : hits) {
      mean += winding * (next_x - x) * height;
      if (winding != 0) filled += (next_x - x) * height;
      x = next_x;
      winding += sign;
    }
  }
};

}  // namespace

TEST_CASE("A pixel is filled by the area that polygons cover together") {
  CHECK(rc::check([] {
    std::vector<Polygon> polygons(static_cast<std::size_t>(draw(1, 4)));
    for (Polygon& polygon : polygons)
      polygon = draw_polygon(-1, 2, -1, 2);
    const CutPolygons cut(polygons);
    PixelFill fill;
    const auto filled = fill.filled(cut.sides, cut.crossings, cut.mean);
    RC_ASSERT(filled.has_value());
    // Tolerance: the lines of the reference miss up to half a line at each end of a side.
    RC_ASSERT(std::fabs(*filled - cut.filled) < 0.01);
  }));
}

TEST_CASE("A pixel whose sides contradict its winding number is not filled") {
  PixelFill fill;
  const std::vector<PixelSide> half{{0.5, 0, 1, 0, 1}};
  CHECK(fill.filled(half, {}, 0.5) == 0.5);
  CHECK(fill.filled(half, {}, 1.5) == 1.0);
  CHECK(fill.filled(half, {}, -0.5) == 0.5);
  CHECK_FALSE(fill.filled(half, {}, 0.6).has_value());
}
