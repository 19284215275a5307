#include "core/mask/rasterizer.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

void add(Rasterizer& rasterizer, const Polygon& polygon) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    rasterizer.add_side(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
}

Mask painted(int width, int height, AntiAliasing anti_aliasing, const std::vector<Polygon>& polygons) {
  Rasterizer rasterizer(Pixels{width}, Pixels{height}, anti_aliasing);
  for (const Polygon& polygon : polygons)
    add(rasterizer, polygon);
  return rasterizer.paint();
}

Polygon box(double left, double top, double right, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

Polygon moved(Polygon polygon, double x, double y) {
  for (PixelPoint& p : polygon)
    p = {p.x + x, p.y + y};
  return polygon;
}

double area_of(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PixelPoint& a = polygon[i];
    const PixelPoint& b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::fabs(twice) / 2;
}

std::int64_t in_grid(double coordinate) {
  return std::llround(coordinate / kGrid);
}

// Returns the exact winding number around a pixel's centre: coordinates are multiples of kGrid within +-100,
// so that everything is whole and fits into 64 bits.
int winding_at_center(const std::vector<Polygon>& polygons, int column, int row) {
  const std::int64_t x = in_grid(column + 0.5), y = in_grid(row + 0.5);
  int winding = 0;
  for (const Polygon& polygon : polygons) {
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      PixelPoint a = polygon[i], b = polygon[(i + 1) % polygon.size()];
      const int sign = a.y < b.y ? 1 : -1;
      if (sign < 0) std::swap(a, b);
      if (in_grid(a.y) > y || in_grid(b.y) <= y) continue;
      // True if the side passes left of the centre, or through it.
      const std::int64_t cross = (in_grid(b.x) - in_grid(a.x)) * (y - in_grid(a.y)) -
                                 (x - in_grid(a.x)) * (in_grid(b.y) - in_grid(a.y));
      if (cross <= 0) winding += sign;
    }
  }
  return winding;
}

// Returns the part of a polygon on the side of a line where `depth` is not negative (Sutherland and Hodgman).
template <typename Depth>
Polygon clipped(const Polygon& polygon, Depth depth) {
  Polygon result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PixelPoint& a = polygon[i];
    const PixelPoint& b = polygon[(i + 1) % polygon.size()];
    const double at_a = depth(a), at_b = depth(b);
    if (at_a >= 0) result.push_back(a);
    if ((at_a < 0) != (at_b < 0)) {
      const double s = at_a / (at_a - at_b);
      result.push_back({a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)});
    }
  }
  return result;
}

double covered_part_of_pixel(const Polygon& polygon, int column, int row) {
  Polygon part = clipped(polygon, [=](const PixelPoint& p) { return p.x - column; });
  part = clipped(part, [=](const PixelPoint& p) { return column + 1 - p.x; });
  part = clipped(part, [=](const PixelPoint& p) { return p.y - row; });
  part = clipped(part, [=](const PixelPoint& p) { return row + 1 - p.y; });
  return area_of(part);
}

// Returns the largest difference in grey levels between the mask and the polygon's exact coverage.
double worst_error(const Mask& mask, const Polygon& polygon) {
  double worst = 0;
  for (int row = 0; row < mask.height().count(); ++row) {
    for (int column = 0; column < mask.width().count(); ++column) {
      const double grey = mask.row(row)[static_cast<std::size_t>(column)];
      worst = std::fmax(worst, std::fabs(grey - 255 * covered_part_of_pixel(polygon, column, row)));
    }
  }
  return worst;
}

// Half a level for the rounding to bytes. The sums are rounded to 2^-15 of a pixel, a side's share in a pixel
// and its two ends' heights by half of that: up to 24 sides in one pixel are 24 * 3 / 2 * 255 / 2^15 = 0.28
// levels.
constexpr double kOneLevel = 1.0;

// Returns the largest difference between a mask and the part of a larger one at (x, y).
int worst_difference(const Mask& mask, const Mask& larger, int x, int y) {
  int worst = 0;
  for (int row = 0; row < mask.height().count(); ++row) {
    const auto part = larger.row(row + y).subspan(static_cast<std::size_t>(x));
    for (std::size_t column = 0; column < mask.row(row).size(); ++column) {
      worst = std::max(worst, std::abs(mask.row(row)[column] - part[column]));
    }
  }
  return worst;
}

// Requires that a pixel is lit where its centre's winding number is not zero. For use within rc::check.
void expect_lit_centers(const Mask& mask, const std::vector<Polygon>& polygons) {
  for (int row = 0; row < mask.height().count(); ++row) {
    for (int column = 0; column < mask.width().count(); ++column) {
      const int expected = winding_at_center(polygons, column, row) != 0 ? 255 : 0;
      RC_ASSERT(static_cast<int>(mask.row(row)[static_cast<std::size_t>(column)]) == expected);
    }
  }
}

constexpr AntiAliasing kBoth[] = {AntiAliasing::On, AntiAliasing::Off};

}  // namespace

TEST_CASE("A rasterizer has 1 to 16384 pixels a side") {
  CHECK_THROWS_AS(Rasterizer(Pixels{0}, Pixels{5}, AntiAliasing::On), std::invalid_argument);
  CHECK_THROWS_AS(Rasterizer(Pixels{5}, Pixels{16385}, AntiAliasing::On), std::invalid_argument);
  CHECK_NOTHROW(Rasterizer(Pixels{16384}, Pixels{1}, AntiAliasing::On));
}

TEST_CASE("Without anti-aliasing a pixel is lit where its centre's winding number is not zero") {
  CHECK(rc::check([] {
    std::vector<Polygon> polygons(static_cast<std::size_t>(draw(1, 4)));
    for (Polygon& polygon : polygons)
      polygon = draw_polygon(-20, 90, -20, 60);
    // More than one word of touched bits.
    expect_lit_centers(painted(70, 40, AntiAliasing::Off, polygons), polygons);
  }));
}

TEST_CASE("A centre exactly on a shared side belongs to exactly one of the two polygons") {
  // Each side runs through pixel centres: upright, level, diagonal and at a slope of 2 in 3.
  const std::vector<std::pair<PixelPoint, PixelPoint>> sides{
      {{4.5, 0}, {4.5, 10}}, {{0, 5.5}, {10, 5.5}}, {{0, 0}, {10, 10}}, {{0.5, 0.5}, {9.5, 6.5}}};
  for (const auto& [a, b] : sides) {
    const bool level = a.y == b.y;
    const Polygon one = level ? Polygon{a, b, {10, 0}, {0, 0}} : Polygon{a, b, {0, 10}, {0, 0}};
    const Polygon other = level ? Polygon{b, a, {0, 10}, {10, 10}} : Polygon{b, a, {10, 0}, {10, 10}};
    const Mask first = painted(10, 10, AntiAliasing::Off, {one});
    const Mask second = painted(10, 10, AntiAliasing::Off, {other});
    for (std::size_t i = 0; i < 100; ++i) {
      CHECK_FALSE((first.pixels()[i] != 0 && second.pixels()[i] != 0));
    }
    if (a.x != 0.5) CHECK(first.lit_pixels() + second.lit_pixels() == 100);
  }
}

// The tie rule: a centre on a side belongs to the area right of it, and a centre on a level side to the area
// below. A row's centre line crosses a side whose ends lie on both sides of the line or whose upper end lies
// on it.
TEST_CASE("A centre exactly on a vertex or a side falls to the right and below") {
  CHECK(rc::check([] {
    std::vector<Polygon> polygons(static_cast<std::size_t>(draw(1, 3)));
    for (Polygon& polygon : polygons) {
      polygon.resize(static_cast<std::size_t>(draw(3, 7)));
      // On corners, centres and the middles of sides of pixels; many sides pass through centres on their way.
      for (PixelPoint& p : polygon)
        p = {static_cast<double>(draw(-10, 60)) / 2, static_cast<double>(draw(-10, 50)) / 2};
    }
    expect_lit_centers(painted(24, 20, AntiAliasing::Off, polygons), polygons);
  }));
}

TEST_CASE("With anti-aliasing a pixel's grey value is its exactly covered part") {
  CHECK(rc::check([] {
    const Polygon star = draw_star({draw_real(0, 24), draw_real(0, 20)}, 0.5, 20);
    RC_ASSERT(worst_error(painted(24, 20, AntiAliasing::On, {star}), star) <= kOneLevel);
  }));
}

TEST_CASE("With anti-aliasing convex polygons are covered exactly") {
  CHECK(rc::check([] {
    // Corners on a stretched circle.
    Polygon polygon = draw_star({0, 0}, 1, 1);
    const double width = draw_real(0.1, 30), height = draw_real(0.1, 30);
    const PixelPoint center{draw_real(-5, 30), draw_real(-5, 25)};
    for (PixelPoint& p : polygon)
      p = {center.x + p.x * width, center.y + p.y * height};
    RC_ASSERT(worst_error(painted(24, 20, AntiAliasing::On, {polygon}), polygon) <= kOneLevel);
  }));
}

TEST_CASE("Polygons far smaller than a pixel and slivers are covered exactly") {
  CHECK(rc::check([] {
    const PixelPoint p{draw_real(2, 10), draw_real(2, 10)};
    const Polygon speck = draw_star(p, 0.01, 0.4);
    RC_ASSERT(worst_error(painted(12, 12, AntiAliasing::On, {speck}), speck) <= kOneLevel);
    const double slope = draw_real(-0.2, 0.2);
    const Polygon sliver{{-1, p.y}, {13, p.y + slope}, {13, p.y + slope + 0.03}, {-1, p.y + 0.02}};
    RC_ASSERT(worst_error(painted(12, 12, AntiAliasing::On, {sliver}), sliver) <= kOneLevel);
  }));
}

TEST_CASE("Polygons hundreds of times the display's size are covered exactly") {
  CHECK(rc::check([] {
    // Flat shapes too: a display's row may pass under a side for thousands of pixels.
    const double across = draw_real(1, 5000), along = draw_real(1, 5000);
    Polygon polygon = draw_star({0, 0}, 0.3, 1);
    const PixelPoint center{draw_real(-along, along), draw_real(-across, across)};
    for (PixelPoint& p : polygon)
      p = {center.x + p.x * along, center.y + p.y * across};
    RC_ASSERT(worst_error(painted(24, 20, AntiAliasing::On, {polygon}), polygon) <= kOneLevel);
  }));
}

TEST_CASE("Slivers of a thousandth of a pixel lose no light and add none") {
  CHECK(rc::check([] {
    constexpr int kSide = 200;
    const PixelPoint a{draw_real(5, 195), draw_real(5, 195)}, b{draw_real(5, 195), draw_real(5, 195)};
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    RC_PRE(length > 20);
    const double width = draw_real(0.001, 0.5);
    const PixelPoint aside{-(b.y - a.y) / length * width, (b.x - a.x) / length * width};
    const Polygon sliver{a, b, {b.x + aside.x, b.y + aside.y}, {a.x + aside.x, a.y + aside.y}};
    const Mask mask = painted(kSide, kSide, AntiAliasing::On, {sliver});
    // Half a level for the rounding to bytes, and, as for kOneLevel, 4 * 3 / 2 * 255 / 2^15 = 0.05 for the
    // rounding of the sums: a share below half a level is dark.
    constexpr double kSliverLevels = 0.55;
    int touched = 0;
    for (int row = 0; row < kSide; ++row) {
      for (int column = 0; column < kSide; ++column) {
        const double along = ((column + 0.5 - a.x) * (b.x - a.x) + (row + 0.5 - a.y) * (b.y - a.y)) / length;
        const double off = ((row + 0.5 - a.y) * (b.x - a.x) - (column + 0.5 - a.x) * (b.y - a.y)) / length;
        const bool far = along < -1 || along > length + 1 || off < -1 || off > width + 1;
        const double level = mask.row(row)[static_cast<std::size_t>(column)];
        RC_ASSERT(!far || level == 0);
        if (far) continue;
        const double covered = covered_part_of_pixel(sliver, column, row);
        RC_ASSERT(std::fabs(level - 255 * covered) <= kSliverLevels);
        touched += covered > 0;
      }
    }
    RC_ASSERT(std::fabs(mask.lit_area() - length * width) <= touched * kSliverLevels / 255);
  }));
}

TEST_CASE("The sum of the coverage is the polygon's area") {
  CHECK(rc::check([] {
    const Polygon star = draw_star({200, 150}, 60, 140);
    const double area = area_of(star);
    RC_PRE(area > 2000.0);
    // Only pixels on the sides are rounded, some thousand at most, by a quarter of a level on average and to
    // both sides: far below 1e-4 of the area.
    const double lit = painted(400, 300, AntiAliasing::On, {star}).lit_area();
    RC_ASSERT(std::fabs(lit - area) <= 1e-4 * area);
  }));
}

TEST_CASE("A square on the pixel grid lights its pixels fully and no other") {
  for (const AntiAliasing mode : kBoth) {
    const Mask mask = painted(100, 50, mode, {box(10, 20, 75, 40)});
    CHECK(mask.lit_pixels() == 65 * 20);
    CHECK(mask.lit_area() == 65.0 * 20.0);
    CHECK(mask.row(20)[10] == 255);
    CHECK(mask.row(39)[74] == 255);
  }
}

TEST_CASE("A polygon's direction does not matter and polygons within polygons follow the non-zero rule") {
  const Polygon outer = box(1, 1, 9, 9), inner = box(3, 3, 7, 7);
  Polygon hole = inner;
  std::ranges::reverse(hole);
  Polygon turned = outer;
  std::ranges::reverse(turned);
  for (const AntiAliasing mode : kBoth) {
    CHECK(painted(10, 10, mode, {outer}) == painted(10, 10, mode, {turned}));
    CHECK(painted(10, 10, mode, {outer, inner}).lit_pixels() == 64);
    CHECK(painted(10, 10, mode, {outer, hole}).lit_pixels() == 64 - 16);
    CHECK(painted(10, 10, mode, {outer, hole, inner}).lit_pixels() == 64);
    CHECK(painted(10, 10, mode, {outer, turned}).lit_pixels() == 0);
  }
}

TEST_CASE("A pixel in which polygons overlap is as bright as the area that they cover together") {
  const Polygon most = box(0.25, 0, 1, 1);
  CHECK(painted(1, 1, AntiAliasing::On, {most}).pixels()[0] == 191);  // 0.75 * 255 = 191.25
  CHECK(painted(1, 1, AntiAliasing::On, {most, most}).pixels()[0] == 191);
  CHECK(painted(1, 1, AntiAliasing::On, {most, box(0, 0, 0.5, 1)}).pixels()[0] == 255);
}

TEST_CASE("Overlaps that are all thinner than a pixel add up") {
  const Polygon little{{0, 0}, {0, 1}, {0.25, 1}, {0.25, 0}};
  CHECK(painted(1, 1, AntiAliasing::On, {little, little}).pixels()[0] == 128);  // 127.5, rounded up
  // In the opposite direction the overlap is detected.
  const Polygon turned{little.rbegin(), little.rend()};
  CHECK(painted(1, 1, AntiAliasing::On, {turned, turned}).pixels()[0] == 64);
}

TEST_CASE("Sixty thousand polygons on top of each other are lit") {
  Rasterizer rasterizer(Pixels{4}, Pixels{4}, AntiAliasing::On);
  for (int i = 0; i < 60'000; ++i)
    add(rasterizer, box(1, 1, 3, 3));
  CHECK(rasterizer.paint().lit_area() == 4.0);
}

TEST_CASE("No light spills beyond a closed polygon") {
  CHECK(rc::check([] {
    constexpr int kWidth = 80, kHeight = 60;
    const double low_x = draw_real(0, 70), high_x = low_x + draw_real(0, 30);
    const double low_y = draw_real(0, 50), high_y = low_y + draw_real(0, 30);
    const Polygon polygon = draw_polygon(low_x, high_x, low_y, high_y);
    for (const AntiAliasing mode : kBoth) {
      const Mask mask = painted(kWidth, kHeight, mode, {polygon});
      for (int row = 0; row < kHeight; ++row) {
        for (int column = 0; column < kWidth; ++column) {
          const bool in_reach = row + 1 > low_y && row < high_y && column + 1 > low_x && column < high_x;
          RC_ASSERT(in_reach || mask.row(row)[static_cast<std::size_t>(column)] == 0);
        }
      }
    }
  }));
}

TEST_CASE("A chain of thousands of tiny sides leaves no residue") {
  // A rough circle: every row holds hundreds of sides, whose rounded shares must cancel at the end of the
  // row.
  Polygon polygon;
  std::uint64_t random = 7;
  for (int i = 0; i < 20'000; ++i) {
    random = random * 6364136223846793005U + 1442695040888963407U;
    const double radius = 20 + static_cast<double>(random >> 40) / (1 << 24) * 5;
    const double angle = 2 * std::numbers::pi * i / 20'000;
    polygon.push_back({30 + radius * std::cos(angle), 30 + radius * std::sin(angle)});
  }
  for (const AntiAliasing mode : kBoth) {
    const Mask mask = painted(80, 60, mode, {polygon});
    for (int row = 0; row < 60; ++row) {
      CHECK(std::ranges::all_of(mask.row(row).subspan(56), [](std::uint8_t grey) { return grey == 0; }));
    }
    CHECK(mask.row(30)[30] == 255);
  }
}

TEST_CASE("A curve of two hundred sides a pixel is covered exactly") {
  // 0.5 / 2^15 of a pixel for each side's share: 200 of them are 0.8 levels, and half a level for the byte.
  Polygon circle;
  for (int i = 0; i < 12'000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 12'000;
    circle.push_back({12.3 + 9.7 * std::cos(angle), 11.8 + 9.7 * std::sin(angle)});
  }
  CHECK(worst_error(painted(24, 24, AntiAliasing::On, {circle}), circle) <= 1.3);
}

TEST_CASE("Polygons wholly outside the display change nothing, however far away they are") {
  for (const AntiAliasing mode : kBoth) {
    const Polygon inside = box(3.25, 4.5, 20.75, 15.125);
    const Mask alone = painted(40, 30, mode, {inside});
    for (const double far : {100.0, 1e6, 1e30, 1e300}) {
      for (const double x : {-1.0, 0.0, 1.0}) {
        for (const double y : {-1.0, 0.0, 1.0}) {
          if (x == 0 && y == 0) continue;
          CAPTURE(far, x, y);
          // As wide as a side's length, or as the display if the polygon lies straight above, below or beside
          // it.
          const auto span = [far](double direction, double side) {
            if (direction < 0) return std::pair{-2 * far, -far};
            return direction > 0 ? std::pair{far, 2 * far} : std::pair{0.0, side};
          };
          const auto [left, right] = span(x, 40);
          const auto [top, bottom] = span(y, 30);
          CHECK(painted(40, 30, mode, {inside, box(left, top, right, bottom)}) == alone);
          const Polygon triangle{{left, top}, {right, bottom}, {left, bottom}};
          CHECK(painted(40, 30, mode, {inside, triangle}) == alone);
        }
      }
    }
  }
}

TEST_CASE("A polygon that reaches far beyond the display lights the part of the display that it covers") {
  for (const AntiAliasing mode : kBoth) {
    for (const double far : {1000.0, 1e30, 1e300}) {
      CAPTURE(far);
      CHECK(painted(40, 30, mode, {box(-far, -far, far, far)}).lit_area() == 1200.0);
      CHECK(painted(40, 30, mode, {box(-far, -far, 7, far)}).lit_area() == 7 * 30.0);
      CHECK(painted(40, 30, mode, {box(7, -far, far, far)}).lit_area() == 33 * 30.0);
      CHECK(painted(40, 30, mode, {box(-far, 11, far, far)}).lit_area() == 40 * 19.0);
      CHECK(painted(40, 30, mode, {box(-far, -far, far, 11)}).lit_area() == 40 * 11.0);
      // The corner beyond the diagonal through the display: sides far away pass no pixel.
      CHECK(painted(40, 30, mode, {{{-far, -far}, {far, -far}, {far, far}, {-far, far}}}).lit_pixels() ==
            1200);
    }
  }
}

TEST_CASE("A 1-bit mask is the same part of a larger display's") {
  CHECK(rc::check([] {
    const auto width = static_cast<int>(draw(1, 70)), height = static_cast<int>(draw(1, 20));
    const Polygon polygon = draw_polygon(-60, 120, -40, 60);
    const Mask mask = painted(width, height, AntiAliasing::Off, {polygon});
    const Mask larger = painted(200, 110, AntiAliasing::Off, {moved(polygon, 64, 44)});
    RC_ASSERT(worst_difference(mask, larger, 64, 44) == 0);
  }));
}

TEST_CASE("A grey mask is the same part of a larger display's") {
  CHECK(rc::check([] {
    const auto width = static_cast<int>(draw(1, 70)), height = static_cast<int>(draw(1, 20));
    const Polygon star = draw_star({draw_real(-20, 90), draw_real(-20, 40)}, 5, 60);
    const Mask mask = painted(width, height, AntiAliasing::On, {star});
    const Mask larger = painted(300, 240, AntiAliasing::On, {moved(star, 128, 96)});
    // The roundings of the parts that are cut off: half of 2^-15 for each side, and one grey level where they
    // tip the byte.
    RC_ASSERT(worst_difference(mask, larger, 128, 96) <= 1);
  }));
}

TEST_CASE(
    "A side that leaves the display at both borders within one row covers what it covers of a larger one") {
  // A third of the side's height lies left of the display, a third in it, a third right of it.
  const Polygon wedge{{-10, 3}, {20, 3.9}, {20, 8}, {-10, 8}};
  const Mask mask = painted(10, 10, AntiAliasing::On, {wedge});
  CHECK(worst_error(mask, wedge) <= kOneLevel);
  CHECK(rc::check([] {
    const auto width = static_cast<int>(draw(1, 30));
    const double left = draw_real(-90, -1), right = draw_real(width + 1, 90), y = draw_real(2, 6);
    const Polygon shallow{{left, y}, {right, y + draw_real(-1, 1)}, {right, 9}, {left, 9}};
    RC_ASSERT(worst_error(painted(width, 10, AntiAliasing::On, {shallow}), shallow) <= kOneLevel);
  }));
}

TEST_CASE("Painting replaces the mask and leaves nothing for the next one") {
  for (const AntiAliasing mode : kBoth) {
    Rasterizer rasterizer(Pixels{100}, Pixels{10}, mode);
    add(rasterizer, box(5, 2, 95, 4));
    CHECK(rasterizer.paint().lit_area() == 180.0);
    CHECK(rasterizer.paint().lit_pixels() == 0);
    add(rasterizer, box(1, 3, 2, 4));
    CHECK(rasterizer.paint().lit_pixels() == 1);
  }
}

TEST_CASE("The order of the sides does not matter") {
  CHECK(rc::check([] {
    std::vector<Polygon> polygons{draw_polygon(-10, 50, -10, 40), draw_polygon(-10, 50, -10, 40)};
    for (const AntiAliasing mode : kBoth) {
      const Mask mask = painted(40, 30, mode, polygons);
      std::vector<Polygon> other{polygons[1], polygons[0]};
      std::rotate(other[0].begin(), other[0].begin() + 1, other[0].end());
      RC_ASSERT(painted(40, 30, mode, other) == mask);
    }
  }));
}
