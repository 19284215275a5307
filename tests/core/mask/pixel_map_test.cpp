#include "core/mask/pixel_map.hpp"

#include "core/engine/contour_engine.hpp"
#include "core/model/placement.hpp"
#include "tests/catch.hpp"
#include "tests/core/near.hpp"
#include "tests/models/models.hpp"
#include "tests/random_shapes.hpp"

namespace {

DisplayGeometry display(int width, int height, double pitch_um = 50) {
  return {Pixels{width}, Pixels{height}, Micrometers{pitch_um}};
}

Bounds flat_bounds(double min_x, double min_y, double max_x, double max_y) {
  return {min_x, min_y, 0, max_x, max_y, 1};
}

// Equations 3.6 to 3.19 as in the thesis, with y_pixel counted from the bottom of the fitted image.
PixelPoint by_the_thesis(double width, double height, const Bounds& b, Point p) {
  const double ar_device = width / height;
  const double ar_object = (b.max_x - b.min_x) / (b.max_y - b.min_y);
  const bool fit_to_width = ar_object >= ar_device;
  const double r = fit_to_width ? width - 1 : height - 1;
  const double v = fit_to_width ? 1 : ar_object;
  const double w = fit_to_width ? 1 / ar_object : 1;
  return {(p.x - b.min_x) / (b.max_x - b.min_x) * r * v, (p.y - b.min_y) / (b.max_y - b.min_y) * r * w};
}

}  // namespace

TEST_CASE("Fit to display follows the thesis's equations, with row 0 at the largest y") {
  CHECK(rc::check([] {
    const auto width = static_cast<int>(draw(2, 4000)), height = static_cast<int>(draw(2, 4000));
    const double x = draw_real(-100, 100), y = draw_real(-100, 100);
    const Bounds bounds = flat_bounds(x, y, x + draw_real(1, 200), y + draw_real(1, 200));
    const Point p{draw_real(bounds.min_x, bounds.max_x), draw_real(bounds.min_y, bounds.max_y)};
    const PixelMap map = PixelMap::fit(display(width, height), bounds);
    const PixelPoint expected = by_the_thesis(width, height, bounds, p);
    const double image_height = by_the_thesis(width, height, bounds, {x, bounds.max_y}).y;
    const PixelPoint pixel = map.to_pixels(p);
    RC_ASSERT(near(pixel.x, expected.x));
    RC_ASSERT(near(pixel.y, image_height - expected.y));
    // The aspect ratio is kept, and the whole model is on the display.
    const PixelPoint right = map.to_pixels({p.x + 1, p.y}), back = map.to_pixels({p.x, p.y + 1});
    RC_ASSERT(near(std::fabs(right.x - pixel.x), map.pixels_per_mm()));
    RC_ASSERT(near(std::fabs(back.y - pixel.y), map.pixels_per_mm()));
    RC_ASSERT(pixel.x >= -testing::kRounding && pixel.x <= width - 1 + testing::kRounding);
    RC_ASSERT(pixel.y >= -testing::kRounding && pixel.y <= height - 1 + testing::kRounding);
  }));
}

TEST_CASE("A wide model fills the display's width and a tall one its height") {
  const PixelMap wide = PixelMap::fit(display(1920, 1080), flat_bounds(-10, 0, 30, 5));
  CHECK(near(wide.to_pixels({-10, 5}).x, 0));
  CHECK(near(wide.to_pixels({-10, 5}).y, 0));
  CHECK(near(wide.to_pixels({30, 0}).x, 1919));
  CHECK(near(wide.to_pixels({30, 0}).y, 1919.0 * 5 / 40));
  const PixelMap tall = PixelMap::fit(display(1920, 1080), flat_bounds(0, -10, 5, 30));
  CHECK(near(tall.to_pixels({5, -10}).y, 1079));
  CHECK(near(tall.to_pixels({5, -10}).x, 1079.0 * 5 / 40));
  // A model with the display's aspect ratio: by equation 3.8, fitted to the width.
  CHECK(near(PixelMap::fit(display(200, 100), flat_bounds(0, 0, 2, 1)).to_pixels({2, 0}).x, 199));
}

TEST_CASE("A model without width or height keeps the scale of its other side") {
  const PixelMap line = PixelMap::fit(display(100, 50), flat_bounds(3, 4, 3, 14));
  CHECK(near(line.to_pixels({3, 14}).y, 0));
  CHECK(near(line.to_pixels({3, 4}).y, 49));
  CHECK(near(line.to_pixels({3, 4}).x, 0));
  const PixelMap flat = PixelMap::fit(display(100, 50), flat_bounds(3, 4, 13, 4));
  CHECK(near(flat.to_pixels({13, 4}).x, 99));
  CHECK(near(flat.to_pixels({13, 4}).y, 0));
  const PixelPoint point = PixelMap::fit(display(100, 50), flat_bounds(3, 4, 3, 4)).to_pixels({3, 4});
  CHECK(point.x == 0);
  CHECK(point.y == 0);
}

TEST_CASE("At true scale the centre lies on the display's centre and a pixel is one pitch wide") {
  CHECK(rc::check([] {
    const DisplayGeometry geometry{Pixels{static_cast<int>(draw(1, 4000))},
                                   Pixels{static_cast<int>(draw(1, 4000))}, Micrometers{draw_real(5, 200)}};
    const Point center{draw_real(-100, 100), draw_real(-100, 100)};
    const Point p{draw_real(-100, 100), draw_real(-100, 100)};
    const PixelPoint pixel = PixelMap::true_scale(geometry, center).to_pixels(p);
    const double pitch_mm = geometry.pixel_pitch.count() / 1000;
    RC_ASSERT(near(pixel.x, geometry.width.count() / 2.0 + (p.x - center.x) / pitch_mm));
    RC_ASSERT(near(pixel.y, geometry.height.count() / 2.0 - (p.y - center.y) / pitch_mm));
  }));
}

TEST_CASE("Larger y lies higher and row 0 is the top") {
  const PixelMap map = PixelMap::true_scale(display(100, 100), {0, 0});
  CHECK(map.to_pixels({0, 2.5}).y == 0);
  CHECK(map.to_pixels({0, -2.5}).y == 100);
  CHECK(map.to_pixels({-2.5, 0}).x == 0);
  CHECK(map.to_pixels({2.5, 0}).x == 100);
}

TEST_CASE("Mirrors exchange left and right or top and bottom") {
  CHECK(rc::check([] {
    DisplayGeometry geometry = display(static_cast<int>(draw(2, 4000)), static_cast<int>(draw(2, 4000)));
    const Bounds bounds = flat_bounds(0, 0, draw_real(1, 100), draw_real(1, 100));
    const Point p{draw_real(0, 100), draw_real(0, 100)};
    for (const bool fitted : {false, true}) {
      const auto pixel_of = [&](bool mirror_x, bool mirror_y) {
        geometry.mirror_x = mirror_x;
        geometry.mirror_y = mirror_y;
        const PixelMap map =
            fitted ? PixelMap::fit(geometry, bounds) : PixelMap::true_scale(geometry, {7, 9});
        RC_ASSERT(map.pixels_per_mm() > 0.0);
        return map.to_pixels(p);
      };
      const PixelPoint plain = pixel_of(false, false);
      RC_ASSERT(near(pixel_of(true, false).x, geometry.width.count() - plain.x));
      RC_ASSERT(pixel_of(true, false).y == plain.y);
      RC_ASSERT(pixel_of(false, true).x == plain.x);
      RC_ASSERT(near(pixel_of(false, true).y, geometry.height.count() - plain.y));
      RC_ASSERT(near(pixel_of(true, true).x, geometry.width.count() - plain.x));
      RC_ASSERT(near(pixel_of(true, true).y, geometry.height.count() - plain.y));
    }
  }));
}

TEST_CASE("A cube of 20 mm is 400 by 400 lit pixels of 50 um, wherever it stands on the pixel grid") {
  const HeightIndex cube(models::box({0, 0, 0}, {20, 20, 20}));
  for (const AntiAliasing anti_aliasing : {AntiAliasing::On, AntiAliasing::Off}) {
    CHECK(rc::check([&] {
      DisplayGeometry geometry = display(640, 500);
      geometry.mirror_x = draw(0, 1) == 1;
      geometry.mirror_y = draw(0, 1) == 1;
      // The cube's corner at this pixel, counted from the upper left.
      const auto column = static_cast<int>(draw(0, 240)), row = static_cast<int>(draw(0, 100));
      const int from_left = geometry.mirror_x ? 240 - column : column;
      const int from_top = geometry.mirror_y ? 100 - row : row;
      const Point center{(320 - from_left) * 0.05, 20 - (250 - from_top) * 0.05};
      ContourEngine engine(cube, {geometry, anti_aliasing}, {PixelMap::true_scale(geometry, center)});
      const Mask& mask = engine.mask_at(Nanometers{draw(0, 19'999'999)});
      RC_ASSERT(mask.lit_pixels() == 400 * 400);
      RC_ASSERT(mask.lit_area() == 400.0 * 400.0);
      for (int y = row; y < row + 400; ++y) {
        const auto lit = mask.row(y).subspan(static_cast<std::size_t>(column), 400);
        RC_ASSERT(std::ranges::all_of(lit, [](std::uint8_t grey) { return grey == 255; }));
      }
    }));
  }
}

TEST_CASE("Factors in X and Y change a cube's pixels to the pixel, wherever it stands on the pixel grid") {
  struct Factors {
    double x, y;
    int columns, rows;  // pixels of a cube that is 400 by 400 without factors
  };
  // The last factors compensate a shrinkage that turns 500 pixels into 400 (20 %) and 405 into 400 (1.2 %).
  for (const Factors& f :
       {Factors{1.25, 0.75, 500, 300}, Factors{0.5, 1, 200, 400}, Factors{1 / 0.8, 1.0125, 500, 405}}) {
    for (const AntiAliasing anti_aliasing : {AntiAliasing::On, AntiAliasing::Off}) {
      CHECK(rc::check([&] {
        // Anywhere in the model's own coordinates; quarters of a millimetre are exact in a float.
        models::Facets facets = models::box({0, 0, 0}, {20, 20, 20});
        models::translate(facets, static_cast<float>(draw(-400, 400)) / 4,
                          static_cast<float>(draw(-400, 400)) / 4, 0);
        orient(facets, {0, 0, 0, {f.x, f.y, 1}});
        const HeightIndex cube(facets);
        DisplayGeometry geometry = display(640, 500);
        geometry.mirror_x = draw(0, 1) == 1;
        geometry.mirror_y = draw(0, 1) == 1;
        const auto column = static_cast<int>(draw(0, 640 - f.columns));
        const auto row = static_cast<int>(draw(0, 500 - f.rows));
        const int from_left = geometry.mirror_x ? 640 - f.columns - column : column;
        const int from_top = geometry.mirror_y ? 500 - f.rows - row : row;
        const Point center{cube.bounds().min_x + (320 - from_left) * 0.05,
                           cube.bounds().max_y - (250 - from_top) * 0.05};
        ContourEngine engine(cube, {geometry, anti_aliasing}, {PixelMap::true_scale(geometry, center)});
        const Mask& mask = engine.mask_at(Nanometers{draw(0, 19'999'999)});
        RC_ASSERT(mask.lit_pixels() == std::int64_t{f.columns} * f.rows);
        for (int y = row; y < row + f.rows; ++y) {
          const auto lit =
              mask.row(y).subspan(static_cast<std::size_t>(column), static_cast<std::size_t>(f.columns));
          RC_ASSERT(std::ranges::all_of(lit, [](std::uint8_t grey) { return grey == 255; }));
        }
      }));
    }
  }
}
