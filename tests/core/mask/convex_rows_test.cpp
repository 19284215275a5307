#include "core/mask/convex_rows.hpp"

#include "tests/catch.hpp"
#include "tests/core/mask/conic_fixture.hpp"
#include "tests/core/random_contours.hpp"

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
