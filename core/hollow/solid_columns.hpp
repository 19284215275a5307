// A model's solid in columns of cells: for each place of a grid, where solid begins and ends from the lowest
// slice up. This is a dexel model (Van Hook 1986), made from the masks of all slices. Immutable once sampled;
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "core/hollow/cavity_grid.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

class SolidColumns {
 public:
  enum class Failure { None, Stopped, TooIntricate };

  // Samples the model at the middles of the slices, by the centres of the cells. Fails if `stop` is requested
  // or if solid begins and ends in more than `most_ends` places. Blocks for a mask of each slice. Memory: 8
  // bytes for each place where solid begins or ends, and 4 for each cell of a slice.
  [[nodiscard]] Failure sample(std::shared_ptr<const HeightIndex> model, const CavityGrid& grid,
                               std::size_t most_ends, const std::stop_token& stop);

  // Returns the slices where solid begins and, in turn, ends in a column, rising; an end is the first slice
  // above the solid. `column` is a cell's place in its slice.
  [[nodiscard]] std::span<const std::uint16_t> ends(std::size_t column) const {
    return std::span(ends_).subspan(starts_[column], starts_[column + 1] - starts_[column]);
  }
  // Returns the number of solid cells in each slice.
  [[nodiscard]] std::span<const std::uint32_t> solid_cells() const { return solid_cells_; }

 private:
  std::vector<std::uint32_t> starts_;  // in ends_, by column; one more than there are columns
  std::vector<std::uint16_t> ends_;
  std::vector<std::uint32_t> solid_cells_;
};

}  // namespace contourd
