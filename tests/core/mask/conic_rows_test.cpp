#include "core/mask/conic_rows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include "tests/catch.hpp"
#include "tests/core/mask/conic_fixture.hpp"
#include "tests/core/random_contours.hpp"

namespace {

// Decides by the ellipse's equation at each centre. Returns nullopt if a centre is too near to the outline to
// decide.
std::optional<bool> holds(const ConicCut& cut, const Point& p) {
  const double x = p.x - cut.origin.x, y = p.y - cut.origin.y;
  const double u = x * cut.along.x + y * cut.along.y, v = y * cut.along.x - x * cut.along.y;
  const double off = v * v - cut.first.at(u) * cut.second.at(u);
  if (std::fabs(off) < 1e-6) return std::nullopt;
  return cut.low < u && u < cut.high && off < 0;
}

constexpr std::int32_t kEllipseColumns = kMillimeterDisplay.width.count();

PixelEllipse draw_pixel_ellipse() {
  return pixel_ellipse(draw_ellipse(), PixelMap::true_scale(kMillimeterDisplay, {0, 0}));
}

}  // namespace

TEST_CASE("A whole cut and one with ends cut off light the pixels whose centres they contain") {
  CHECK(rc::check([] {
    const DisplayGeometry display = draw_mirrored_display();
    ConicCut cut = draw_ellipse();
    const bool cut_off = draw(0, 2) == 0;
    if (cut_off) {
      cut.low = draw_real(-30, 0);
      cut.low = std::max(cut.low, -cut.high);
      cut.high = std::min(cut.high, draw_real(0.1, 30));
      cut.whole = false;
    }
    const Mask mask = lit_by(cut, display);
    for (std::int32_t y = 0; y < 48; ++y) {
      for (std::int32_t x = 0; x < 64; ++x) {
        const Point center = on_plate(display, {x + 0.5, y + 0.5});
        const auto held = holds(cut, center);
        if (held && !cut_off) RC_ASSERT((mask.row(y)[static_cast<std::size_t>(x)] == 255) == *held);
      }
    }
    if (cut_off) {
      Contours outline;
      append_outline(cut, outline);
      RC_ASSERT(mask == painted_by_centers(outline, display));
    }
  }));
}

TEST_CASE("A row ends where its last centre is, and an ellipse beside the display lights nothing") {
  CHECK(lit_by(ellipse({0, 0}, 0, 0.7, 0.4)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0.5, 0.5}, 0, 0.7, 0.4)).lit_pixels() == 1);
  CHECK(lit_by(ellipse({0.5, 0.5}, 0, 1.1, 0.4)).lit_pixels() == 3);
  CHECK(lit_by(ellipse({0.5, 0.5}, 90, 1.1, 0.4)).lit_pixels() == 3);
  CHECK(lit_by(ellipse({50, 0}, 0, 10, 10)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0, 40}, 0, 10, 10)).lit_pixels() == 0);
  CHECK(lit_by(ellipse({0, 0}, 0, 1e6, 1e6)).lit_pixels() == 64 * 48);
}

TEST_CASE("A convex polygon lights the pixels whose centres it contains, like filling by centres") {
  CHECK(rc::check([] {
    const DisplayGeometry display = draw_mirrored_display();
    // Corners on a circle are a convex polygon; it may be cut off by the display, or beside it.
    const Point middle = draw_middle();
    const double radius = draw_real(0.3, 30);
    std::vector<Point> corners;
    const std::int64_t count = draw(3, 40);
    for (std::int64_t i = 0; i < count; ++i) {
      const double angle =
          2 * std::numbers::pi * (static_cast<double>(i) + draw_real(0, 0.9)) / static_cast<double>(count);
      corners.push_back({middle.x + radius * std::cos(angle), middle.y + radius * std::sin(angle)});
    }
    const Contours loop = one_loop(corners);
    RC_ASSERT(lit_by(loop, display) == painted_by_centers(loop, display));
  }));
}

TEST_CASE("A centre on a side is lit if the polygon lies right of it or below") {
  // 64 x 48 pixels of 1 mm: the plate's centre is the corner of four pixels, whose centres are 0.5 away from
  // it.
  const Mask mask = lit_by(one_loop({{0.5, -0.5}, {2.5, -0.5}, {2.5, 2.5}, {0.5, 2.5}}));
  CHECK(mask.lit_pixels() == 6);
  CHECK(mask.row(24 - 3)[32] == 255);
  CHECK(mask.row(24 - 1)[33] == 255);
  CHECK(mask.row(24)[32] == 0);
}

TEST_CASE("A reversed polygon, one without width and one far away are handled") {
  CHECK(lit_by(one_loop({{0, 0}, {0, 3}, {3, 3}, {3, 0}})).lit_pixels() == 9);
  CHECK(lit_by(one_loop({{0, 0}, {3, 3}})).lit_pixels() == 0);
  CHECK(lit_by(one_loop({{0, 0}})).lit_pixels() == 0);
  CHECK(lit_by(one_loop({{1e300, 0}, {1e300, 3}, {2e300, 3}})).lit_pixels() == 0);
  CHECK(lit_by(one_loop({{-1e300, -1e300}, {1e300, -1e300}, {1e300, 1e300}, {-1e300, 1e300}})).lit_pixels() ==
        64 * 48);
}

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
