// Solids that were drawn touching, as they are in files: each with its own corners, rounded to the file's
// decimals or to floats. They shrink as one.

#include "core/contour/contour_offset.hpp"
#include "tests/catch.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

constexpr double kShrink = 0.1;  // mm; a gap would open to twice this

struct Rounding {
  const char* name;
  double step_mm;      // step of the decimals; 0: none
  double from_origin;  // in mm; the coordinates are rounded to floats at this distance
};

constexpr Rounding kRoundings[] = {{"1e-3 mm", 1e-3, 0},
                                   {"1e-4 mm", 1e-4, 0},
                                   {"floats at 600 mm", 0, 600},
                                   {"floats at 2000 mm", 0, 2000},
                                   {"1e-3 mm at 600 mm", 1e-3, 600}};

Point rounded(Point p, const Rounding& rounding) {
  const auto to_step = [&](double v) {
    v += rounding.from_origin;
    if (rounding.step_mm > 0) v = std::round(v / rounding.step_mm) * rounding.step_mm;
    return static_cast<double>(static_cast<float>(v));
  };
  return {to_step(p.x), to_step(p.y)};
}

Point at_angle(Point p, double degrees) {
  const double c = std::cos(degrees * std::numbers::pi / 180), s = std::sin(degrees * std::numbers::pi / 180);
  return {p.x * c - p.y * s, p.x * s + p.y * c};
}

Loop placed(Loop loop, double degrees, const Rounding& rounding) {
  for (Point& p : loop)
    p = rounded(at_angle(p, degrees), rounding);
  return loop;
}

// A wall of 30 by 12 mm: six courses of bricks, every other one begun with half a brick, so that corners meet
// the middle of walls.
std::vector<Loop> brick_bond(double degrees, const Rounding& rounding) {
  std::vector<Loop> bricks;
  for (int course = 0; course < 6; ++course) {
    const double low = 2 * course;
    for (double left = course % 2 == 0 ? 0 : -2.5; left < 30; left += 5) {
      bricks.push_back(
          placed(rectangle(std::max(left, 0.0), low, std::min(left + 5, 30.0), low + 2), degrees, rounding));
    }
  }
  return bricks;
}

// A disc of 24 sectors that meet in its middle.
std::vector<Loop> sectors(double degrees, const Rounding& rounding) {
  std::vector<Loop> all;
  for (int i = 0; i < 24; ++i) {
    all.push_back(
        placed({{0, 0}, at_angle({10, 0}, i * 15), at_angle({10, 0}, i * 15 + 15)}, degrees, rounding));
  }
  return all;
}

Contours shrunk(const std::vector<Loop>& loops, double by) {
  Contours moved;
  ContourOffset().offset(contours_from(loops), Millimeters{-by}, moved);
  return moved;
}

}  // namespace

TEST_CASE("A brick bond shrinks as one wall, however its corners are rounded and turned") {
  for (const Rounding& rounding : kRoundings) {
    for (int degrees = 0; degrees < 90; degrees += 3) {
      CAPTURE(rounding.name, degrees);
      const Contours wall = shrunk(brick_bond(degrees, rounding), kShrink);
      CHECK(wall.loops.size() == 1);
      // The outline is rounded by a micrometre, along 84 mm.
      CHECK(std::fabs(signed_area(wall) - 29.8 * 11.8) < 84e-3);
    }
  }
}

TEST_CASE("Sectors of a disc shrink as one disc") {
  const double apothem = 10 * std::cos(std::numbers::pi / 24) - kShrink;
  const double area = 24 * apothem * apothem * std::tan(std::numbers::pi / 24);
  for (const Rounding& rounding : kRoundings) {
    for (int degrees = 0; degrees < 15; ++degrees) {
      CAPTURE(rounding.name, degrees);
      const Contours disc = shrunk(sectors(degrees, rounding), kShrink);
      CHECK(disc.loops.size() == 1);
      CHECK(std::fabs(signed_area(disc) - area) < 63e-3);  // a micrometre along its outline
    }
  }
}

TEST_CASE("A gap wider than rounding opens by twice the distance") {
  for (const double gap : {0.0025, 0.005, 0.02}) {
    CAPTURE(gap);
    const Contours apart = shrunk({rectangle(0, 0, 10, 10), rectangle(10 + gap, 0, 20, 10)}, kShrink);
    CHECK(apart.loops.size() == 2);
    CHECK(std::fabs(signed_area(apart) - (19.6 - gap) * 9.8) < 1e-6);
  }
}

TEST_CASE("A facet far away closes no gap") {
  // A float's step at this distance is 8 um.
  const Contours apart = shrunk(
      {rectangle(0, 0, 10, 10), rectangle(10.02, 0, 20, 10), {{1e5, 1e5}, {1.001e5, 1e5}, {1e5, 1.001e5}}},
      kShrink);
  double area = 0;
  for (const ContourLoop& loop : apart.loops) {
    if (apart.points_of(loop).front().x < 100) area += signed_area(apart.points_of(loop));
  }
  CHECK(apart.loops.size() == 3);
  // The sweep's grid has to be wider: 2^-13 mm, along 79 mm.
  CHECK(std::fabs(area - 19.58 * 9.8) < 79.0 / (1 << 13));
}

TEST_CASE("A solid cut in two in any direction and rounded shrinks as one") {
  CHECK(rc::check([] {
    // A convex part, cut in two by a line: each half rounds the line's ends separately.
    const double radius = draw_real(2, 20), degrees = draw_real(0, 360), off = draw_real(-0.8, 0.8) * radius;
    const Loop whole = circle({0, 0}, radius, static_cast<int>(draw(8, 90)));
    const Rounding& rounding = kRoundings[draw(0, 4)];
    Loop left, right;
    const auto take_half = [&](Loop& half, double sign) {
      for (std::size_t i = 0; i < whole.size(); ++i) {
        const Point a = whole[i], b = whole[(i + 1) % whole.size()];
        if (sign * (a.x - off) > 0) half.push_back(a);
        if ((a.x - off) * (b.x - off) < 0) {
          const double s = (off - a.x) / (b.x - a.x);
          half.push_back({off, a.y + s * (b.y - a.y)});
        }
      }
    };
    take_half(left, -1);
    take_half(right, 1);
    // More corners on one half's wall than on the other's.
    std::vector<Loop> parts{placed(left, degrees, rounding), placed(right, degrees, rounding)};
    const Contours one = shrunk(parts, kShrink);
    RC_ASSERT(one.loops.size() == 1U);
    const double exact = signed_area(shrunk({placed(whole, degrees, rounding)}, kShrink));
    RC_ASSERT(std::fabs(signed_area(one) - exact) < 7 * radius * 1.5e-3);
  }));
}
