// Finds the cells of a slice that are farther from the model's outside than a wall is thick, in all three
// dimensions. A cell is part of the wall if the centre of a cell outside the solid lies within the thickness
// of the wall and half a cell of its own centre.
//
// The squares of distances along x, y and z add up, so the search runs along z, x and y in turn, after
// Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions (2012): along z the columns have
// the distance to the solid's ends; along x the lower envelope of parabolas; along y, where only whether a
// distance is small enough counts, a running maximum. Takes time in proportion to the cells of the slice.
//
// Not thread-safe; allocates in its constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/hollow/cavity_grid.hpp"
#include "core/hollow/solid_columns.hpp"

namespace contourd {

class WallDistance {
 public:
  // The thickest wall, in cells.
  static constexpr double kThickestCells = 250;

  // `columns` must outlive this. REQUIRES: the wall has at most kThickestCells cells.
  WallDistance(const SolidColumns& columns, const CavityGrid& grid, Millimeters wall);

  // Moves on to the next slice, from the lowest one. Returns a byte for each cell, row by row: 1 where it is
  // within the wall; empty if every cell is. Valid until the next call.
  [[nodiscard]] std::span<const std::uint8_t> next();

 private:
  // A parabola of the lower envelope: the one that is lowest from a column on.
  struct Parabola {
    std::int32_t from, column, height;
  };

  [[nodiscard]] bool measure_columns();
  void measure_row(std::int32_t row);
  void spread(std::int32_t row);

  const SolidColumns& columns_;
  std::int32_t width_, height_;
  std::int32_t most_squared_;  // square of the greatest distance within the wall, in cells
  std::int32_t farthest_;      // root of most_squared_, rounded down
  std::int32_t slice_ = -1;
  std::vector<std::uint32_t> next_end_;   // by column: the first of its ends above the slice
  std::vector<std::uint8_t> up_or_down_;  // by cell: distance along z to the outside, at most farthest_ + 1
  std::vector<std::int16_t> reach_;       // by cell: how far along y it makes cells part of the wall; -1: not
  std::vector<std::int16_t> reach_of_;    // by squared distance
  std::vector<std::int16_t> running_;     // by column of the grid
  std::vector<std::uint8_t> within_;
  std::vector<Parabola> envelope_;
};

}  // namespace contourd
