// The pictures that show a lamp's light over a display: small fields for a meter, and a white picture for a
// photo. Pure functions; thread-safe.
#pragma once

#include "core/calibration/lamp_fit.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// A grid of equal cells over a display.
struct LampGrid {
  static constexpr int kLeast = 3, kMost = 9;  // columns and rows

  int columns = 0, rows = 0;

  [[nodiscard]] int cells() const { return columns * rows; }
  // Returns the middle of a cell; cells are counted from 0, row by row from the upper left one.
  [[nodiscard]] LampPlace middle(int cell) const;
};

// A square of the display, in pixels.
struct LampField {
  int left = 0, top = 0, side = 0;
  LampPlace middle;
};
// Returns the field of a grid's cell. Fields are three fifths of the narrower side of a cell wide; the outer
// ones touch the display's edges, where readings determine a surface best. REQUIRES: kLeast to kMost columns
// and rows, a cell of the grid, a display of at least 100 pixels on each side.
[[nodiscard]] LampField lamp_field(const LampGrid& grid, int cell, Pixels width, Pixels height);
// Draws the field of lamp_field() in white.
[[nodiscard]] Mask draw_lamp_field(const LampGrid& grid, int cell, Pixels width, Pixels height);

// Draws a white picture with black dots in its corners: one at the upper left, two at the upper right, three
// at the lower right, four at the lower left. The dots lie within a fiftieth of the shorter side from the
// upper or lower edge. REQUIRES: a display of at least 100 pixels on each side.
[[nodiscard]] Mask draw_lamp_photo(Pixels width, Pixels height);

}  // namespace contourd
