// Where a sweep's pixels and layers are. Values; thread-safe as any value is.
#pragma once

#include <cstdint>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"

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

// Layers count from 1: layer 0 is the plate.
struct SweepGrid {
  DisplayGeometry display;  // without mirrors
  Nanometers step;

  [[nodiscard]] double pixel_mm() const { return to_millimeters(display.pixel_pitch).count(); }
  [[nodiscard]] double step_mm() const { return to_millimeters(step).count(); }
  // Where a layer is cut: in its middle, above the plate.
  [[nodiscard]] Nanometers height_of(std::int32_t layer) const { return step * layer - step / 2; }
  // A pixel's middle, from the plate's centre.
  [[nodiscard]] Point place_of(SweepPixel pixel) const {
    return on_plate(display, {pixel.column + 0.5, pixel.row + 0.5});
  }
  [[nodiscard]] bool holds(SweepPixel pixel) const {
    return pixel.column >= 0 && pixel.row >= 0 && pixel.column < display.width.count() &&
           pixel.row < display.height.count();
  }
};

// The build area's, with a margin of a pixel: layers of 50 um, and pixels of 50 um as far as there are no
// more than 2048 a side. REQUIRES: the build area has a size.
[[nodiscard]] SweepGrid sweep_grid(const DisplayGeometry& build_area);

}  // namespace contourd
