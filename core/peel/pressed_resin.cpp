#include "core/peel/pressed_resin.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/peel/lit_cells.hpp"

namespace contourd {
namespace {

constexpr CellRule kRule{};  // widths need no more accuracy than four pixels

// Returns the radius of the largest circle of lit cells, in cells. Its middle is the middle of a cell, or a
// corner of four cells where an even number of them lies side by side.
double widest_radius(const LitCells& cells) {
  return std::ranges::max(rim_distances(cells)) / 6.0;
}

// Returns the sum of C^2 / P of all dark areas that lit ones enclose, in cells. The rim's sides are stairs,
// too long by up to 41 percent, and its cells as much too few: a third of the sides and two thirds of the
// cells are its length to 6 percent, as by the 3-4 chamfer.
double enclosed_areas(const LitCells& cells) {
  const auto columns = static_cast<std::size_t>(cells.columns());
  std::vector<std::uint8_t> seen(cells.size());
  std::vector<std::size_t> open;
  double sum = 0;
  for (std::size_t first = 0; first < cells.size(); ++first) {
    if (seen[first] != 0 || cells.is_lit(first)) continue;
    double area = 0, sides = 0, rim_cells = 0;
    const auto visit = [&](std::size_t cell) {
      if (cells.is_lit(cell)) {
        ++sides;
      } else if (seen[cell] == 0) {
        seen[cell] = 1;
        open.push_back(cell);
      }
    };
    visit(first);
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      ++area;
      const double sides_before = sides;
      if (cell % columns > 0) visit(cell - 1);
      if (cell % columns + 1 < columns) visit(cell + 1);
      if (cell >= columns) visit(cell - columns);
      if (cell + columns < cells.size()) visit(cell + columns);
      if (sides > sides_before) ++rim_cells;
    }
    if (first > 0) sum += area * area * 3 / (sides + 2 * rim_cells);  // the first cell belongs to the outside
  }
  return sum;
}

// Returns the factor of an area and of the radius of the largest circle within it.
double solid_shape_mm4(double area_mm2, double radius_mm) {
  const double circle_mm2 = std::numbers::pi * radius_mm * radius_mm;
  const double roundness = std::min(circle_mm2 / area_mm2, 1.0);  // 1: a disc, 0: a long strip
  return (4 - 2.5 * roundness) * area_mm2 * radius_mm * radius_mm;
}

}  // namespace

double press_shape_mm4(const Mask& light, Micrometers pixel_pitch) {
  const double pitch_mm = pixel_pitch.count() / 1000, cell_mm = kRule.side * pitch_mm;
  const double area_mm2 = light.lit_area() * pitch_mm * pitch_mm;
  const LitCells cells(light, kRule);
  const double radius_mm = widest_radius(cells) * cell_mm;
  if (radius_mm == 0) return 0;
  const double enclosed_mm3 = enclosed_areas(cells) * cell_mm * cell_mm * cell_mm;
  return solid_shape_mm4(area_mm2, radius_mm) + 24 * radius_mm * enclosed_mm3;
}

double press_shape_mm4(Millimeters width, Millimeters height) {
  return solid_shape_mm4(width.count() * height.count(), std::min(width, height).count() / 2);
}

std::chrono::duration<double> press_time(const PressedResin& resin, double shape_mm4, Nanometers gap) {
  expects(resin.viscosity_pa_s > 0 && resin.stiffness_n_mm > 0 && gap > Nanometers{},
          "resin, axis and gap resist");
  const double gap_mm = to_millimeters(gap).count();
  // Pa s is N s / m^2, so that Pa s mm^4 / (mm^3 N / mm) is a millionth of a second.
  return std::chrono::duration<double>(3 * resin.viscosity_pa_s * 1e-6 * shape_mm4 /
                                       (gap_mm * gap_mm * gap_mm * resin.stiffness_n_mm));
}

}  // namespace contourd
