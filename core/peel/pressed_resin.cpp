#include "core/peel/pressed_resin.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::int32_t kBlock = 4;  // pixels on a side of a cell: widths need no more accuracy

// The lit cells of a mask, each a square of pixels, within a border of dark cells.
class Cells {
 public:
  explicit Cells(const Mask& light)
      : columns_((light.width().count() + kBlock - 1) / kBlock + 2),
        rows_((light.height().count() + kBlock - 1) / kBlock + 2),
        lit_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    std::vector<std::uint8_t> counts(static_cast<std::size_t>(columns_));
    for (std::int32_t row = 0; row < rows_ - 2; ++row) {
      std::ranges::fill(counts, std::uint8_t{0});
      const std::int32_t end = std::min((row + 1) * kBlock, light.height().count());
      for (std::int32_t y = row * kBlock; y < end; ++y)
        count(light.row(y), counts);
      for (std::int32_t column = 0; column < columns_ - 2; ++column)
        lit_[place(column + 1, row + 1)] = counts[static_cast<std::size_t>(column)] >= kBlock * kBlock / 2;
    }
  }

  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::size_t size() const { return lit_.size(); }
  [[nodiscard]] bool is_lit(std::size_t cell) const { return lit_[cell] != 0; }
  [[nodiscard]] std::size_t place(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

 private:
  static void count(std::span<const std::uint8_t> pixels, std::vector<std::uint8_t>& counts) {
    for (std::size_t x = 0; x < pixels.size(); ++x)
      counts[x / kBlock] = static_cast<std::uint8_t>(counts[x / kBlock] + (pixels[x] >= 128 ? 1 : 0));
  }

  std::int32_t columns_, rows_;
  std::vector<std::uint8_t> lit_;
};

// Returns the radius of the largest circle of lit cells, in cells. Its middle is the middle of a cell, or a
// corner of four cells where an even number of them lies side by side. The distances are those of Borgefors's
// 3-4 chamfer (1986), within 6 percent of the Euclidean ones.
double widest_radius(const Cells& cells) {
  constexpr int kStraight = 3, kDiagonal = 4;
  const auto columns = static_cast<std::size_t>(cells.columns());
  std::vector<std::uint16_t> distance(cells.size());
  const auto nearer = [&](std::size_t cell, std::size_t from, int step) {
    distance[cell] = static_cast<std::uint16_t>(std::min<int>(distance[cell], distance[from] + step));
  };
  for (std::size_t cell = columns + 1; cell + columns + 1 < cells.size(); ++cell) {
    if (!cells.is_lit(cell)) continue;
    distance[cell] = 0xffff;
    nearer(cell, cell - 1, kStraight);
    nearer(cell, cell - columns, kStraight);
    nearer(cell, cell - columns - 1, kDiagonal);
    nearer(cell, cell - columns + 1, kDiagonal);
  }
  double widest = 0;
  for (std::size_t cell = cells.size() - columns - 1; cell-- > columns + 1;) {
    if (!cells.is_lit(cell)) continue;
    nearer(cell, cell + 1, kStraight);
    nearer(cell, cell + columns, kStraight);
    nearer(cell, cell + columns + 1, kDiagonal);
    nearer(cell, cell + columns - 1, kDiagonal);
    const std::uint16_t corner = std::min(
        {distance[cell], distance[cell + 1], distance[cell + columns], distance[cell + columns + 1]});
    // The middle of the last dark cell is half a cell beyond the rim, and that of a lit cell beside a corner
    // half a cell nearer to the rim.
    widest = std::max({widest, distance[cell] / double{kStraight} - 0.5, corner / double{kStraight}});
  }
  return widest;
}

// Returns the sum of C^2 / P of all dark areas that lit ones enclose, in cells. The rim's sides are stairs,
// too long by up to 41 percent, and its cells as much too few: a third of the sides and two thirds of the
// cells are its length to 6 percent, as by the 3-4 chamfer.
double enclosed_areas(const Cells& cells) {
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
  const double pitch_mm = pixel_pitch.count() / 1000, cell_mm = kBlock * pitch_mm;
  const double area_mm2 = light.lit_area() * pitch_mm * pitch_mm;
  const Cells cells(light);
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
