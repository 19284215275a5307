#include "core/peel/lit_cells.hpp"

#include <algorithm>
#include <span>

namespace contourd {
namespace {

std::int32_t cells_across(Pixels length, const CellRule& rule) {
  return (length.count() + rule.side - 1) / rule.side + 2;
}

// Counts the pixels of a row that can light a cell, by column of cells.
void count(std::span<const std::uint8_t> pixels, const CellRule& rule, std::span<std::int32_t> counts) {
  const auto side = static_cast<std::size_t>(rule.side);
  for (std::size_t x = 0; x < pixels.size(); ++x)
    counts[x / side] += pixels[x] >= rule.least_grey ? 1 : 0;
}

}  // namespace

LitCells::LitCells(const Mask& light, const CellRule& rule) {
  expects(rule.side >= 1, "a cell has pixels");
  columns_ = cells_across(light.width(), rule);
  rows_ = cells_across(light.height(), rule);
  lit_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  std::vector<std::int32_t> counts(static_cast<std::size_t>(columns_));
  for (std::int32_t row = 0; row < rows_ - 2; ++row) {
    std::ranges::fill(counts, 0);
    const std::int32_t end = std::min((row + 1) * rule.side, light.height().count());
    for (std::int32_t y = row * rule.side; y < end; ++y)
      count(light.row(y), rule, counts);
    for (std::int32_t column = 0; column < columns_ - 2; ++column)
      lit_[place(column + 1, row + 1)] = counts[static_cast<std::size_t>(column)] >= rule.least_pixels;
  }
}

std::vector<std::uint16_t> rim_distances(const LitCells& cells) {
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
  std::vector<std::uint16_t> sixths(cells.size());
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
    sixths[cell] = static_cast<std::uint16_t>(std::max(2 * distance[cell] - 3, 2 * corner));
  }
  return sixths;
}

}  // namespace contourd
