// The grid of a sweep: its pixels, and the step of its heights. Values; thread-safe as any value is.
#pragma once

#include <cstdint>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/overhangs/sweep_layers.hpp"

namespace contourd {

// A pixel of a sweep's layer.
struct SweepPixel {
  std::int32_t column = 0, row = 0;
  bool operator==(const SweepPixel&) const = default;
};

[[nodiscard]] inline double squared_distance(SweepPixel a, SweepPixel b) {
  const double columns = a.column - b.column, rows = a.row - b.row;
  return columns * columns + rows * rows;
}

struct SweepGrid {
  DisplayGeometry display;  // without mirrors
  Nanometers step;          // of LayerObserver

  [[nodiscard]] double pixel_mm() const { return to_millimeters(display.pixel_pitch).count(); }
  [[nodiscard]] double step_mm() const { return to_millimeters(step).count(); }
  // Returns a pixel's middle, from the plate's centre.
  [[nodiscard]] Point place_of(SweepPixel pixel) const {
    return on_plate(display, {pixel.column + 0.5, pixel.row + 0.5});
  }
  [[nodiscard]] bool holds(SweepPixel pixel) const {
    return pixel.column >= 0 && pixel.row >= 0 && pixel.column < display.width.count() &&
           pixel.row < display.height.count();
  }
};

// Returns the grid for a build area, with a margin of one pixel: pixels of 50 um, or as large as needed to
// have at most 2048 a side. REQUIRES: the build area has a size.
[[nodiscard]] SweepGrid sweep_grid(const DisplayGeometry& build_area, Nanometers step = kDefaultSweptLayer);

}  // namespace contourd
