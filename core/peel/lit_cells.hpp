// A mask in cells, squares of pixels, within a border of dark cells, and the distances of its lit cells from
// the dark ones. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// The cells of a mask, and the pixels that light one.
struct CellRule {
  std::int32_t side = 4;  // pixels
  std::uint8_t least_grey = 128;
  std::int32_t least_pixels = 8;
};

class LitCells {
 public:
  // REQUIRES: a rule with a side of at least a pixel.
  LitCells(const Mask& light, const CellRule& rule);

  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::size_t size() const { return lit_.size(); }
  [[nodiscard]] bool is_lit(std::size_t cell) const { return lit_[cell] != 0; }
  [[nodiscard]] std::size_t place(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }
  // True if a cell belongs to the border.
  [[nodiscard]] bool is_border(std::size_t cell) const {
    const auto columns = static_cast<std::size_t>(columns_);
    return cell < columns || cell + columns >= size() || cell % columns == 0 || cell % columns + 1 == columns;
  }

  // Lights a cell. REQUIRES: not of the border.
  void light(std::size_t cell) {
    expects(!is_border(cell), "the border is dark");
    lit_[cell] = 1;
  }

 private:
  std::int32_t columns_ = 0, rows_ = 0;
  std::vector<std::uint8_t> lit_;
};

// Returns the distance of each lit cell's middle from the nearest dark cells, in sixths of a cell, or that of
// its corner with three lit ones if it is greater; 0 for dark cells. The distances are those of Borgefors's
// 3-4 chamfer (1986), within 6 percent of the Euclidean ones.
[[nodiscard]] std::vector<std::uint16_t> rim_distances(const LitCells& cells);

}  // namespace contourd
