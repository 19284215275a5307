#include "core/mask/exact_side.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

TEST_CASE("A quarter turn from x to y leads to the positive side") {
  CHECK(side_of({0, 0}, {4, 0}, {1, 1}) == 1);
  CHECK(side_of({0, 0}, {4, 0}, {1, -1}) == -1);
  CHECK(side_of({0, 0}, {4, 0}, {99, 0}) == 0);
  CHECK(side_of({1, 1}, {1, 1}, {5, 3}) == 0);
}

TEST_CASE("A point just beside a line is distinguished from a point on it") {
  // A point on the line, whose slope no double represents exactly.
  CHECK(side_of({0.5, 0.5}, {3.5, 1.5}, {2, 1}) == 0);
  CHECK(side_of({0.1, 0.1}, {0.3, 0.3}, {0.7, 0.7}) == 0);
  CHECK(side_of({0.1, 0.1}, {0.3, 0.3}, {0.7, std::nextafter(0.7, 1.0)}) == 1);
  CHECK(side_of({0.1, 0.1}, {0.3, 0.3}, {0.7, std::nextafter(0.7, 0.0)}) == -1);
  CHECK(side_of({-1e38, -1e38}, {1e38, 1e38}, {1e-38, 1e-38}) == 0);
  CHECK(side_of({-1e38, -1e38}, {1e38, 1e38}, {1e-38, 1.1e-38}) == 1);
}

TEST_CASE("The sign is that of integer arithmetic") {
  CHECK(rc::check([] {
    const auto point = [] { return PixelPoint{draw_real(-100, 100), draw_real(-100, 100)}; };
    const PixelPoint a = point(), b = point();
    // Half of the points lie on the line or a grid step beside it.
    PixelPoint p = point();
    if (draw(0, 1) == 1) p = {2 * b.x - a.x, 2 * b.y - a.y + static_cast<double>(draw(-1, 1)) * kGrid};
    const auto whole = [](double v) { return std::llround(v / kGrid); };
    // Differences below 2^31, products below 2^62.
    const std::int64_t cross = (whole(b.x) - whole(a.x)) * (whole(p.y) - whole(a.y)) -
                               (whole(b.y) - whole(a.y)) * (whole(p.x) - whole(a.x));
    RC_ASSERT(side_of(a, b, p) == (cross > 0) - (cross < 0));
  }));
}
