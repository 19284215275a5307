#include "core/mask/convex_rows.hpp"

#include <vector>

#include "core/mask/rasterizer.hpp"
#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

using namespace contourd;
using namespace contourd::testing;

namespace {

constexpr DisplayGeometry kDisplay{Pixels{64}, Pixels{48}, Micrometers{1000.0}};

Contours loop_of(std::vector<Point> corners) {
  const auto count = static_cast<std::uint32_t>(corners.size());
  return {std::move(corners), {{0, count}}, {}, 0};
}

Mask lit_by(const Contours& contours, const DisplayGeometry& display = kDisplay) {
  Rasterizer rasterizer(display.width, display.height, AntiAliasing::On);
  (void)rasterizer.paint();
  rasterizer.light(contours, PixelMap::true_scale(display, {0, 0}));
  return rasterizer.mask();
}

Mask painted(const Contours& contours, const DisplayGeometry& display = kDisplay) {
  Rasterizer rasterizer(display.width, display.height, AntiAliasing::Off);
  rasterizer.add_loops(contours, PixelMap::true_scale(display, {0, 0}));
  return rasterizer.paint();
}

}  // namespace

TEST_CASE("A convex polygon lights the pixels whose centres it contains, like filling by centres") {
  CHECK(rc::check([] {
    DisplayGeometry display = kDisplay;
    display.mirror_x = draw(0, 1) == 1;
    display.mirror_y = draw(0, 1) == 1;
    // Corners on a circle are a convex polygon; it may be cut off by the display, or beside it.
    const Point middle{draw_real(-40, 40), draw_real(-30, 30)};
    const double radius = draw_real(0.3, 30);
    std::vector<Point> corners;
    const std::int64_t count = draw(3, 40);
    for (std::int64_t i = 0; i < count; ++i) {
      const double angle =
          2 * std::numbers::pi * (static_cast<double>(i) + draw_real(0, 0.9)) / static_cast<double>(count);
      corners.push_back({middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle)});
    }
    const Contours loop = loop_of(corners);
    RC_ASSERT(lit_by(loop, display) == painted(loop, display));
  }));
}

TEST_CASE("A centre on a side is lit if the polygon lies right of it or below") {
  // 64 x 48 pixels of 1 mm: the plate's centre is the corner of four pixels, whose centres are 0.5 away from
  // it.
  const Mask mask = lit_by(loop_of({{0.5, -0.5}, {2.5, -0.5}, {2.5, 2.5}, {0.5, 2.5}}));
  CHECK(mask.lit_pixels() == 6);
  CHECK(mask.row(24 - 3)[32] == 255);
  CHECK(mask.row(24 - 1)[33] == 255);
  CHECK(mask.row(24)[32] == 0);
}

TEST_CASE("A reversed polygon, one without width and one far away are handled") {
  CHECK(lit_by(loop_of({{0, 0}, {0, 3}, {3, 3}, {3, 0}})).lit_pixels() == 9);
  CHECK(lit_by(loop_of({{0, 0}, {3, 3}})).lit_pixels() == 0);
  CHECK(lit_by(loop_of({{0, 0}})).lit_pixels() == 0);
  CHECK(lit_by(loop_of({{1e300, 0}, {1e300, 3}, {2e300, 3}})).lit_pixels() == 0);
  CHECK(lit_by(loop_of({{-1e300, -1e300}, {1e300, -1e300}, {1e300, 1e300}, {-1e300, 1e300}})).lit_pixels() ==
        64 * 48);
}
