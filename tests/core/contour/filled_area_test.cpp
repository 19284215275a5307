#include "core/contour/filled_area.hpp"

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/near.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/random_shapes.hpp"

using models::inverted;
using models::together;

namespace {

double area_of(const models::Facets& facets, double z) {
  return filled_area_mm2(contours_of(facets, z));
}

}  // namespace

TEST_CASE("The area where two boxes overlap counts once") {
  const auto facets = together(models::box({0, 0, 0}, {10, 10, 10}), models::box({5, 5, 0}, {15, 15, 10}));
  CHECK(near(area_of(facets, 5), 175));
}

TEST_CASE("A box within a box of the same winding adds nothing") {
  const auto facets = together(models::box({0, 0, 0}, {20, 20, 20}), models::box({5, 5, 5}, {15, 15, 15}));
  CHECK(near(area_of(facets, 10), 400));
}

TEST_CASE("Thousands of walls beside each other are filled without a seam") {
  // Uprights beside each other, each a little higher than the previous one: their tops form a slope.
  constexpr int kCount = 12'000;
  Contours contours;
  for (int i = 0; i < kCount; ++i) {
    const double left = 12.0 * i / kCount, right = left + 12.0 / kCount, top = 10 + 10.0 * i / kCount;
    contours.loops.push_back({static_cast<std::uint32_t>(contours.points.size()), 4});
    for (const Point& point : {Point{left, 0}, Point{right, 0}, Point{right, top}, Point{left, top}})
      contours.points.push_back(point);
  }
  // A staircase: half a step of 10 mm / 12,000 less than the slope. Walls that are shared up to a double's
  // rounding meet on the grid, 2^-30 of 20 mm, along 12,000 walls of up to 20 mm.
  CHECK(near(filled_area_mm2(contours), 12 * (15 - 0.5 * 10.0 / kCount), 12'000 * 20 * 20.0 / (1 << 30)));
}

TEST_CASE("A cavity is not filled and a solid within it is") {
  const auto hollow =
      together(models::box({0, 0, 0}, {30, 30, 30}), inverted(models::box({5, 5, 5}, {25, 25, 25})));
  CHECK(near(area_of(hollow, 15), 500));
  CHECK(near(area_of(together(hollow, models::box({10, 10, 10}, {20, 20, 20})), 15), 600));
  const auto cavity =
      together(models::box({0, 0, 0}, {20, 20, 20}), inverted(models::box({5, 5, 5}, {15, 15, 15})));
  CHECK(near(area_of(cavity, 10), 300));
}

TEST_CASE("Boxes that share a wall or stand on each other are filled without a seam") {
  CHECK(
      near(area_of(together(models::box({0, 0, 0}, {10, 10, 10}), models::box({10, 0, 0}, {20, 10, 10})), 5),
           200));
  const auto stacked = together(models::box({0, 0, 0}, {10, 10, 5}), models::box({0, 0, 5}, {10, 10, 10}));
  CHECK(near(area_of(stacked, 5), 100));
}

TEST_CASE("A model that faces inwards is filled too") {
  CHECK(near(area_of(inverted(models::box({0, 0, 0}, {10, 10, 10})), 5), 100));
}

TEST_CASE("Both halves of a bow-tie are filled") {
  CHECK(near(filled_area_mm2(one_loop({{0, 0}, {10, 10}, {10, 0}, {0, 10}})), 50));
  // Sideways, so that the crossing lies within a strip between end points of other heights.
  CHECK(near(filled_area_mm2(one_loop({{0, 0}, {10, 0}, {0, 10}, {10, 10}})), 50));
}

TEST_CASE("A five-pointed star's heart is filled") {
  std::vector<Point> star;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * 2 * i / 5;
    star.push_back({10 * std::sin(angle), 10 * std::cos(angle)});
  }
  // Ten right triangles of the radius and the inner one, which is r cos(72 deg) / cos(36 deg).
  const double deg36 = std::numbers::pi / 5;
  const double area = 10 * 0.5 * 10 * 10 * std::cos(2 * deg36) / std::cos(deg36) * std::sin(deg36);
  // Where its sides cross they meet on the grid, 2^-30 of 20 mm, along an outline of 73 mm.
  CHECK(near(filled_area_mm2(one_loop(star)), area, 73 * 20.0 / (1 << 30)));
}

TEST_CASE("Empty contours and lines have no area") {
  CHECK(filled_area_mm2({}) == 0.0);
  CHECK(filled_area_mm2(one_loop({{0, 0}, {10, 5}})) == 0.0);
  CHECK(filled_area_mm2(one_loop({{0, 0}, {10, 0}, {5, 0}})) == 0.0);
}

TEST_CASE("A polygon that does not cross itself has the area of the shoelace formula") {
  CHECK(rc::check([] {
    std::vector<Point> points;
    for (const PixelPoint& p :
         testing::draw_star({testing::draw_real(-50, 50), testing::draw_real(-50, 50)}, 1, 20)) {
      points.push_back({p.x, p.y});
    }
    RC_ASSERT(near(filled_area_mm2(one_loop(points)), std::fabs(testing::signed_area(points))));
  }));
}

TEST_CASE("The area of overlapping boxes is that of inclusion and exclusion") {
  CHECK(rc::check([] {
    const auto interval = [] {
      const double low = testing::draw_real(0, 50);
      return std::pair{low, low + testing::draw_real(0.1, 50)};
    };
    const auto [ax0, ax1] = interval();
    const auto [ay0, ay1] = interval();
    const auto [bx0, bx1] = interval();
    const auto [by0, by1] = interval();
    Contours contours = one_loop({{ax0, ay0}, {ax1, ay0}, {ax1, ay1}, {ax0, ay1}});
    contours.points.insert(contours.points.end(), {{bx0, by0}, {bx1, by0}, {bx1, by1}, {bx0, by1}});
    contours.loops.push_back({4, 4});
    const double common = std::fmax(0, std::fmin(ax1, bx1) - std::fmax(ax0, bx0)) *
                          std::fmax(0, std::fmin(ay1, by1) - std::fmax(ay0, by0));
    const double area = (ax1 - ax0) * (ay1 - ay0) + (bx1 - bx0) * (by1 - by0) - common;
    RC_ASSERT(near(filled_area_mm2(contours), area));
  }));
}

TEST_CASE("The area is the mask's lit area") {
  const DisplayGeometry display{Pixels{480}, Pixels{480}, Micrometers{50.0}};
  for (const auto& [facets, name] :
       {std::pair{models::sphere(10, 16), "sphere"}, std::pair{models::gyroid_sphere(10, 5, 24), "gyroid"}}) {
    const HeightIndex model(facets);
    ContourEngine engine(model, {.display = display}, {PixelMap::true_scale(display, {0, 0})});
    for (const std::int64_t height_nm : {1'234'567, 7'777'777, 10'000'000, 18'000'001}) {
      CAPTURE(name, height_nm);
      const double lit_mm2 = engine.mask_at(Nanometers{height_nm}).lit_area() * 0.05 * 0.05;
      const Contours& contours = engine.contours_at(Nanometers{height_nm});
      // Only pixels that a side passes are rounded, by half a grey level at most: a side of n pixels' length
      // passes at most 2 n + 2. (No two walls pass one pixel at these wall thicknesses.)
      const double sides_px =
          2 * perimeter_mm(contours) / 0.05 + 2 * static_cast<double>(contours.points.size());
      const double tolerance_mm2 = sides_px * 0.51 / 255 * 0.05 * 0.05;
      CHECK(near(filled_area_mm2(contours), lit_mm2, tolerance_mm2));
      CHECK(lit_mm2 > 10 * tolerance_mm2);
    }
  }
}

TEST_CASE("A soup of crossing sides has the area that it covers on a display") {
  std::vector<Point> points;
  std::uint64_t random = 1;
  const auto next = [&random] {
    random = random * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(random >> 40) / (1 << 24) * 100;
  };
  // The longer soup crosses itself more often than the exact calculation allows: its area is an estimate.
  const int count = GENERATE(600, 3000);
  for (int i = 0; i < count; ++i)
    points.push_back({next(), next()});
  Rasterizer rasterizer(Pixels{1000}, Pixels{1000}, AntiAliasing::Off);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& a = points[i];
    const Point& b = points[(i + 1) % points.size()];
    rasterizer.add_side({a.x * 10, a.y * 10}, {b.x * 10, b.y * 10});
  }
  const double sampled_mm2 = rasterizer.paint().lit_area() / 100;
  // A million samples of which at most half are by chance: 500 of 0.01 mm^2, six times over. The estimate is
  // by 500 lines: another 0.5 %.
  CHECK(near(filled_area_mm2(one_loop(points)), sampled_mm2, 30 + 0.005 * sampled_mm2));
  CHECK(sampled_mm2 > 5000);
}
