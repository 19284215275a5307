#include "core/calibration/lamp_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr double kFieldShare = 0.6;      // share of a cell's shorter side
constexpr double kDotShare = 1.0 / 100;  // share of the display's shorter side
constexpr Pixels kLeastSide{100};

void fill(Mask& mask, int left, int top, int side, std::uint8_t grey) {
  for (int y = top; y < top + side; ++y)
    std::fill_n(mask.row(y).begin() + left, side, grey);
}

}  // namespace

LampPlace LampGrid::middle(int cell) const {
  const int column = cell % columns, row = cell / columns;
  return {(2.0 * column + 1) / columns - 1, (2.0 * row + 1) / rows - 1};
}

LampField lamp_field(const LampGrid& grid, int cell, Pixels width, Pixels height) {
  expects(std::min(grid.columns, grid.rows) >= LampGrid::kLeast, "a grid of at least three columns and rows");
  expects(std::max(grid.columns, grid.rows) <= LampGrid::kMost, "a grid of at most nine columns and rows");
  expects(cell >= 0 && cell < grid.cells(), "a cell of the grid");
  expects(std::min(width, height) >= kLeastSide, "a display of at least 100 pixels on each side");
  const double cell_side = std::min(1.0 * width.count() / grid.columns, 1.0 * height.count() / grid.rows);
  LampField field{.side = static_cast<int>(std::lround(kFieldShare * cell_side)), .middle = {}};
  const auto from = [&field](int index, int count, Pixels of) {
    return static_cast<int>(std::lround(1.0 * index * (of.count() - field.side) / (count - 1)));
  };
  field.left = from(cell % grid.columns, grid.columns, width);
  field.top = from(cell / grid.columns, grid.rows, height);
  field.middle = {(2.0 * field.left + field.side) / width.count() - 1,
                  (2.0 * field.top + field.side) / height.count() - 1};
  return field;
}

Mask draw_lamp_field(const LampGrid& grid, int cell, Pixels width, Pixels height) {
  const LampField field = lamp_field(grid, cell, width, height);
  Mask mask(width, height);
  fill(mask, field.left, field.top, field.side, 255);
  return mask;
}

Mask draw_lamp_photo(Pixels width, Pixels height) {
  expects(std::min(width, height) >= kLeastSide, "a display of at least 100 pixels on each side");
  Mask mask(width, height);
  for (int y = 0; y < height.count(); ++y)
    std::ranges::fill(mask.row(y), std::uint8_t{255});
  const int dot = std::max(1, static_cast<int>(kDotShare * std::min(width, height).count()));
  const int right = width.count() - 2 * dot, below = height.count() - 2 * dot;
  for (int number = 1; number <= 4; ++number)
    for (int i = 0; i < number; ++i) {
      const bool is_right = number == 2 || number == 3;
      fill(mask, is_right ? right - 2 * i * dot : (2 * i + 1) * dot, number > 2 ? below : dot, dot, 0);
    }
  return mask;
}

}  // namespace contourd
