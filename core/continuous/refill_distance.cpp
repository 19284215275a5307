#include "core/continuous/refill_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Distances by the chamfer are up to 6 percent too short.
constexpr double kChamferError = 1.06;
// From a cell's middle to its corner, in cells.
constexpr double kToCorner = std::numbers::sqrt2 / 2;

// An area of cells that touch each other, also in corners.
struct Area {
  std::vector<std::size_t> cells;
  double column_sum = 0, row_sum = 0;
  std::uint16_t widest = 0;  // sixths of a cell
};

// Finds the areas of lit cells, one after the other.
class Areas {
 public:
  explicit Areas(const LitCells& lit)
      : lit_(lit),
        columns_(static_cast<std::size_t>(lit.columns())),
        distances_(rim_distances(lit)),
        seen_(lit.size()) {}

  // Finds the next area. False if there is none.
  [[nodiscard]] bool next(Area& area) {
    area.cells.clear();
    area.column_sum = area.row_sum = 0;
    area.widest = 0;
    while (first_ < seen_.size() && !is_new(first_))
      ++first_;
    if (first_ == seen_.size()) return false;
    visit(first_, area);
    for (std::size_t done = 0; done < area.cells.size(); ++done)
      visit_neighbors(area.cells[done], area);
    return true;
  }

  // Returns the radius, in cells, of a circle around an area: its middle is the mean of the cells' middles.
  [[nodiscard]] double radius(const Area& area) const {
    const auto count = static_cast<double>(area.cells.size());
    const double column = area.column_sum / count, row = area.row_sum / count;
    double square = 0;
    for (const std::size_t cell : area.cells) {
      const std::size_t cell_column = cell % columns_, cell_row = cell / columns_;
      const double across = static_cast<double>(cell_column) - column;
      const double along = static_cast<double>(cell_row) - row;
      square = std::max(square, across * across + along * along);
    }
    return std::sqrt(square) + kToCorner;
  }

 private:
  [[nodiscard]] bool is_new(std::size_t cell) const { return lit_.is_lit(cell) && seen_[cell] == 0; }

  void visit(std::size_t cell, Area& area) {
    seen_[cell] = 1;
    area.cells.push_back(cell);
    const std::size_t column = cell % columns_, row = cell / columns_;
    area.column_sum += static_cast<double>(column);
    area.row_sum += static_cast<double>(row);
    area.widest = std::max(area.widest, distances_[cell]);
  }

  // A lit cell is not of the border, so that it has eight neighbors.
  void visit_neighbors(std::size_t cell, Area& area) {
    for (const std::size_t row : {cell - columns_, cell, cell + columns_})
      for (const std::size_t near : {row - 1, row, row + 1})
        if (is_new(near)) visit(near, area);
  }

  const LitCells& lit_;
  std::size_t columns_;
  std::vector<std::uint16_t> distances_;
  std::vector<std::uint8_t> seen_;
  std::size_t first_ = 0;
};

}  // namespace

CellRule refill_cells(Pixels width, Pixels height) {
  constexpr double kMostCells = 250'000;
  constexpr double kLeastSide = 4;
  const double pixels = static_cast<double>(width.count()) * height.count();
  const double side = std::max(std::ceil(std::sqrt(pixels / kMostCells)), kLeastSide);
  return {.side = static_cast<std::int32_t>(side), .least_grey = 1, .least_pixels = 1};
}

Millimeters RefillDistance::add_slab(LitCells lit) {
  expects(open_.empty() || open_.size() == lit.size(), "slabs have as many cells");
  fill_closed_holes(lit);
  Areas areas(lit);
  Area area;
  double widest = 0;
  while (areas.next(area)) {
    const double from_rim = kChamferError * area.widest / 6;
    if (from_rim > widest)
      widest = std::max(widest, std::min(from_rim, areas.radius(area) / std::numbers::sqrt2));
  }
  return cell_ * widest;
}

// Lights the dark cells that are neither connected to the border nor open beneath.
void RefillDistance::fill_closed_holes(LitCells& lit) {
  const auto columns = static_cast<std::size_t>(lit.columns());
  std::vector<std::uint8_t> open(lit.size());
  std::vector<std::size_t> reached;
  const auto visit = [&](std::size_t cell) {
    if (lit.is_lit(cell) || open[cell] != 0) return;
    open[cell] = 1;
    reached.push_back(cell);
  };
  for (std::size_t cell = 0; cell < lit.size(); ++cell) {
    if (lit.is_border(cell) || (!open_.empty() && open_[cell] != 0)) visit(cell);
  }
  while (!reached.empty()) {
    const std::size_t cell = reached.back();
    reached.pop_back();
    if (cell % columns > 0) visit(cell - 1);
    if (cell % columns + 1 < columns) visit(cell + 1);
    if (cell >= columns) visit(cell - columns);
    if (cell + columns < lit.size()) visit(cell + columns);
  }
  for (std::size_t cell = 0; cell < lit.size(); ++cell)
    if (!lit.is_lit(cell) && open[cell] == 0) lit.light(cell);
  open_ = std::move(open);
}

}  // namespace contourd
