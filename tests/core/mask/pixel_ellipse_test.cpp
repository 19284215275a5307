#include "core/mask/pixel_ellipse.hpp"

#include "tests/catch.hpp"
#include "tests/core/mask/conic_fixture.hpp"

namespace {

constexpr std::int32_t kEllipseColumns = kMillimeterDisplay.width.count();

PixelEllipse draw_pixel_ellipse() {
  return pixel_ellipse(draw_ellipse(), PixelMap::true_scale(kMillimeterDisplay, {0, 0}));
}

}  // namespace

TEST_CASE("Row ends are the same with wide vectors and with the instructions of every processor") {
  CHECK(rc::check([] {
    const PixelEllipse ellipse = draw_pixel_ellipse();
    const auto top = static_cast<std::int32_t>(std::floor(ellipse.middle.y - ellipse.reach_y));
    const auto rows = static_cast<std::size_t>(2 * ellipse.reach_y + 2);
    std::vector<std::int32_t> first(rows), end(rows), baseline_first(rows), baseline_end(rows);
    find_row_ends(ellipse, top, kEllipseColumns, {first, end});
    find_row_ends_baseline(ellipse, top, kEllipseColumns, {baseline_first, baseline_end});
    RC_ASSERT(first == baseline_first);
    RC_ASSERT(end == baseline_end);
  }));
}

TEST_CASE("An ellipse reaches as far as its rows do") {
  CHECK(rc::check([] {
    const PixelEllipse ellipse = draw_pixel_ellipse();
    double farthest = 0;
    for (int i = -1000; i <= 1000; ++i) {
      const double y = ellipse.reach_y * i / 1000;
      const double half = std::sqrt(std::max(0.0, ellipse.flat - ellipse.bend * y * y));
      farthest = std::max({farthest, ellipse.lean * y + half, half - ellipse.lean * y});
    }
    // The distance of one step along the outline, where the outline is nearly upright.
    RC_ASSERT(farthest <= ellipse.reach_x * (1 + 1e-9));
    RC_ASSERT(farthest > ellipse.reach_x * 0.99);
  }));
}
