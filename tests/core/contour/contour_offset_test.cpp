#include "core/contour/contour_offset.hpp"

#include "tests/catch.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

constexpr double kChord = ContourOffset::kChordError.count();

Contours moved(const std::vector<Loop>& loops, double distance) {
  Contours result;
  ContourOffset().offset(contours_from(loops), Millimeters{distance}, result);
  return result;
}

double moved_area(const std::vector<Loop>& loops, double distance) {
  return signed_area(moved(loops, distance));
}

// True if `area` falls short of `exact` by at most the area that the chords of an arc of this length can
// lack.
bool within_chords(double area, double exact, double arc_length) {
  return area <= exact + 1e-9 && area >= exact - arc_length * kChord;
}

// Returns points of the contours' sides, every `step`, that have an empty side: one into which a circle of
// this radius fits, which touches the side there. The least radius is that at which the outline distinguishes
// points, since a gap may be a thin wedge.
std::vector<Point> borders_of_empty(const Contours& contours, double step,
                                    double radius = ContourUnion::kFileRounding.count()) {
  std::vector<Point> borders;
  const auto is_empty = [&](Point center) {
    if (winding_around(contours, center) != 0) return false;
    const bool least = radius == ContourUnion::kFileRounding.count();
    return least || distance_to_sides(contours, center) > 0.999 * radius;
  };
  for_each_side(contours, [&](Point a, Point b) {
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    const int count = static_cast<int>(length / step) + 1;
    for (int i = 0; i <= count; ++i) {
      const double s = static_cast<double>(i) / count;
      const Point p{a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)};
      const Point beside{-(b.y - a.y) * radius / length, (b.x - a.x) * radius / length};
      if (is_empty({p.x + beside.x, p.y + beside.y}) || is_empty({p.x - beside.x, p.y - beside.y}))
        borders.push_back(p);
    }
  });
  return borders;
}

double nearest(const std::vector<Point>& points, Point p) {
  double distance = 1e9;
  for (const Point& point : points)
    distance = std::min(distance, std::hypot(point.x - p.x, point.y - p.y));
  return distance;
}

double cross(Point origin, Point a, Point b) {
  return (a.x - origin.x) * (b.y - origin.y) - (b.x - origin.x) * (a.y - origin.y);
}

// True if two sides of the loop meet at so small an angle that the wall between them is thinner than twice
// the outline's rounding, and so may not show, for more than a micrometre.
bool has_a_thin_wall(const Loop& loop) {
  const double least_sine = 2 * ContourUnion::kFileRounding.count() / 1e-3;
  const std::size_t count = loop.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 1; j < count; ++j) {
      const Point a = loop[i], b = loop[(i + 1) % count], c = loop[j], d = loop[(j + 1) % count];
      const Point u{b.x - a.x, b.y - a.y}, v{d.x - c.x, d.y - c.y};
      const double lengths = std::hypot(u.x, u.y) * std::hypot(v.x, v.y);
      if (std::fabs(u.x * v.y - u.y * v.x) >= least_sine * lengths) continue;
      const bool neighbours = j == i + 1 || (i == 0 && j == count - 1);
      const bool spike = neighbours && u.x * v.x + u.y * v.y < 0;
      const bool crossing = !neighbours && (cross(a, b, c) > 0) != (cross(a, b, d) > 0) &&
                            (cross(c, d, a) > 0) != (cross(c, d, b) > 0);
      if (spike || crossing) return true;
    }
  }
  return false;
}

std::vector<Loop> draw_loops() {
  std::vector<Loop> loops(static_cast<std::size_t>(draw(1, 4)));
  for (Loop& loop : loops)
    loop = loop_of(draw(0, 1) == 0 ? draw_polygon(-10, 10, -10, 10)
                                   : draw_star({draw_real(-8, 8), draw_real(-8, 8)}, 1, 6));
  std::erase_if(loops, has_a_thin_wall);
  return loops;
}

}  // namespace

TEST_CASE("A square grows by its sides and four quarter circles and shrinks to a square") {
  const std::vector<Loop> square{rectangle(-5, 2, 5, 12)};
  for (const double d : {0.01, 0.05, 0.3, 2.0}) {
    CAPTURE(d);
    CHECK(within_chords(moved_area(square, d), 100 + 40 * d + std::numbers::pi * d * d,
                        2 * std::numbers::pi * d));
    const Contours smaller = moved(square, -d);
    CHECK(smaller.loops.size() == 1);
    CHECK(smaller.points.size() == 4);
    CHECK(std::fabs(signed_area(smaller) - (10 - 2 * d) * (10 - 2 * d)) < 1e-9);
  }
}

TEST_CASE("A circle's radius and a ring's radii change by the distance") {
  const int corners = 720;
  const Loop outer = circle({3, 4}, 8, corners), inner = turned(circle({3, 4}, 5, corners));
  // Returns a regular polygon's area from the radius of its inscribed circle, which changes by the distance.
  const double side_factor = corners * std::tan(std::numbers::pi / corners);
  const double cosine = std::cos(std::numbers::pi / corners);
  const auto area = [&](double radius) { return side_factor * radius * radius; };
  for (const double d : {-1.4, -0.2, -0.013, 0.013, 0.2, 1.4}) {
    CAPTURE(d);
    // Corners that open are made of chords: less area there, more if the corner is a hole's.
    const double slack = 60 * kChord;
    CHECK(std::fabs(moved_area({outer}, d) - area(8 * cosine + d)) < slack);
    CHECK(std::fabs(moved_area({outer, inner}, d) - area(8 * cosine + d) + area(5 * cosine - d)) < slack);
    CHECK(moved({outer, inner}, d).loops.size() == 2);
  }
  CHECK(moved({outer, inner}, 5.1).loops.size() == 1);  // the hole closes
  CHECK(moved({outer, inner}, -1.6).loops.empty());     // the wall vanishes
}

TEST_CASE("A wall thinner than twice the distance vanishes and one thicker stays") {
  CHECK(moved({rectangle(0, 0, 20, 0.2)}, -0.11).loops.empty());
  CHECK(moved({rectangle(0, 0, 20, 0.2)}, -0.1).loops.empty());
  CHECK(std::fabs(moved_area({rectangle(0, 0, 20, 0.2)}, -0.09) - 19.82 * 0.02) < 1e-9);
  // A wall between two lumps, which come apart.
  const std::vector<Loop> lumps{rectangle(0, 0, 5, 5), rectangle(4, 2, 11, 2.2), rectangle(10, 0, 15, 5)};
  CHECK(moved(lumps, 0).loops.size() == 1);
  CHECK(moved(lumps, -0.09).loops.size() == 1);
  const Contours parted = moved(lumps, -0.15);
  CHECK(parted.loops.size() == 2);
  // Where the wall was, each lump bulges between the quarter circles around the two inner corners: twice the
  // integral of r - sqrt(r^2 - x^2) from 0 to half the wall's 0.2 mm.
  const double r2 = 0.15 * 0.15, half = 0.1;
  const double bulge =
      2 * (0.15 * half - (half * std::sqrt(r2 - half * half) + r2 * std::asin(half / 0.15)) / 2);
  CHECK(std::fabs(signed_area(parted) - 2 * (4.7 * 4.7 + bulge)) < 4 * 0.15 * kChord);
}

TEST_CASE("A square narrower than twice the distance vanishes however it is turned, as a part or as a hole") {
  for (int degrees = 0; degrees < 90; ++degrees) {
    CAPTURE(degrees);
    Loop square;
    for (int corner = 0; corner < 4; ++corner) {
      const double angle = (degrees + 90 * corner) * std::numbers::pi / 180;
      square.push_back({std::sqrt(0.5) * std::cos(angle), std::sqrt(0.5) * std::sin(angle)});  // side 1
    }
    CHECK(moved({square}, -0.51).loops.empty());
    CHECK(moved({square}, -0.49).loops.size() == 1);
    CHECK(moved({rectangle(-5, -5, 5, 5), turned(square)}, 0.51).loops.size() == 1);
    CHECK(moved({rectangle(-5, -5, 5, 5), turned(square)}, 0.49).loops.size() == 2);
  }
}

TEST_CASE("A hole grows when the part shrinks, and solids that grow together become one") {
  CHECK(std::fabs(moved_area({rectangle(0, 0, 10, 10), turned(rectangle(4, 4, 6, 6))}, -0.5) -
                  (81 - (9 - 1 + std::numbers::pi / 4))) < 2 * std::numbers::pi * kChord);
  CHECK(moved({rectangle(0, 0, 4, 4), rectangle(4.2, 0, 8, 4)}, 0.09).loops.size() == 2);
  CHECK(moved({rectangle(0, 0, 4, 4), rectangle(4.2, 0, 8, 4)}, 0.11).loops.size() == 1);
}

TEST_CASE("Solids that overlap or share a wall shrink as one, without a gap between them") {
  for (const double left : {10.0, 9.5, 4.0, 10.000001}) {
    const Contours smaller = moved({rectangle(0, 0, 10, 10), rectangle(left, 2, 20, 8)}, -0.25);
    CAPTURE(left);
    CHECK(smaller.loops.size() == 1);
    // 9.5 x 9.5 and 10 x 5.5, and at each of the two inner corners a square without its quarter circle.
    const double exact = 9.5 * 9.5 + 10 * 5.5 + 2 * 0.0625 * (1 - std::numbers::pi / 4);
    // The chords of these, and 60 mm of sides on which points within 2^-15 mm are equal.
    CHECK(std::fabs(signed_area(smaller) - exact) < 0.8 * kChord + 60.0 / 32768);
    CHECK(winding_around(smaller, {10, 5}) == 1);
  }
}

TEST_CASE("Loops that run the wrong way move like any others") {
  CHECK(
      within_chords(moved_area({turned(rectangle(0, 0, 10, 10))}, 0.5), 100 + 20 + std::numbers::pi / 4, 4));
}

TEST_CASE("A distance of 0 gives the outline") {
  CHECK(moved_area({rectangle(0, 0, 10, 10), rectangle(5, 5, 15, 15)}, 0) == 175);
}

TEST_CASE("Grown contours contain every point within the distance and no other") {
  CHECK(rc::check([] {
    const std::vector<Loop> loops = draw_loops();
    const Contours contours = contours_from(loops);
    const double distance = draw_real(0.01, 2);
    const Contours grown = moved(loops, distance);
    for (int i = 0; i < 300; ++i) {
      const Point p{draw_real(-14, 14), draw_real(-14, 14)};
      const bool inside = winding_around(contours, p) != 0;
      const double away = distance_to_sides(contours, p);
      // The chords, and the rounding of points that count as equal.
      if (std::fabs(away - distance) < kChord + 1e-3 || away < 1e-3) continue;
      RC_ASSERT((winding_around(grown, p) > 0) == (inside || away < distance));
    }
  }));
}

TEST_CASE("Shrunk contours contain every point farther inside than the distance and no other") {
  CHECK(rc::check([] {
    const std::vector<Loop> loops = draw_loops();
    const Contours contours = contours_from(loops);
    const double distance = draw_real(0.01, 1.5);
    const Contours shrunk = moved(loops, -distance);
    constexpr double kStep = 0.01;
    const std::vector<Point> borders = borders_of_empty(contours, kStep);
    for (int i = 0; i < 100; ++i) {
      const Point p{draw_real(-10, 10), draw_real(-10, 10)};
      const bool inside = winding_around(contours, p) != 0;
      double away = nearest(borders, p);
      // A hole smaller than the step may lie between two of its points.
      if (inside && away > distance && winding_around(shrunk, p) == 0)
        away = nearest(borders_of_empty(contours, kStep / 50), p);
      // Holes into which a circle of the closing's radius does not fit are closed before shrinking.
      if (inside && away < distance && winding_around(shrunk, p) > 0)
        away = nearest(borders_of_empty(contours, kStep / 50, ContourOffset::kClosing.count()), p);
      if (std::fabs(away - distance) < kStep + kChord + 1e-3) continue;
      RC_ASSERT((winding_around(shrunk, p) > 0) == (inside && away > distance));
    }
  }));
}
