// Ellipses on a display of 64 by 48 pixels of 1 mm, and the masks of shapes that are lit by pixel centres.
#pragma once

#include <cmath>
#include <numbers>
#include <span>

#include "core/mask/rasterizer.hpp"
#include "tests/random_shapes.hpp"

namespace contourd::testing {

inline constexpr DisplayGeometry kMillimeterDisplay{Pixels{64}, Pixels{48}, Micrometers{1000.0}};

inline DisplayGeometry draw_mirrored_display() {
  DisplayGeometry display = kMillimeterDisplay;
  display.mirror_x = draw(0, 1) == 1;
  display.mirror_y = draw(0, 1) == 1;
  return display;
}

// Draws a point on the display or beside it.
inline Point draw_middle() {
  return {draw_real(-40, 40), draw_real(-30, 30)};
}

inline ConicCut ellipse(Point middle, double degrees, double half_length, double half_width) {
  const double turn = degrees * std::numbers::pi / 180, narrow = half_width / half_length;
  return {middle,
          {std::cos(turn), std::sin(turn)},
          -half_length,
          half_length,
          {half_width, narrow},
          {half_width, -narrow},
          true};
}

inline ConicCut draw_ellipse() {
  return ellipse(draw_middle(), draw_real(0, 360), draw_real(0.3, 30), draw_real(0.3, 30));
}

template <typename Shape>
Mask lit_by(const Shape& shape, const DisplayGeometry& display = kMillimeterDisplay) {
  Rasterizer rasterizer(display.width, display.height, AntiAliasing::On);
  (void)rasterizer.paint();
  rasterizer.light(shape, PixelMap::true_scale(display, {0, 0}));
  return rasterizer.mask();
}
inline Mask lit_by(const ConicCut& cut, const DisplayGeometry& display = kMillimeterDisplay) {
  return lit_by(std::span<const ConicCut>(&cut, 1), display);
}

inline Mask painted_by_centers(const Contours& contours, const DisplayGeometry& display) {
  Rasterizer rasterizer(display.width, display.height, AntiAliasing::Off);
  rasterizer.add_loops(contours, PixelMap::true_scale(display, {0, 0}));
  return rasterizer.paint();
}

}  // namespace contourd::testing
