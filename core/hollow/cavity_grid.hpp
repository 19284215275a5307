// The cells in which a model is searched for room for a cavity: cubes, in columns along x, rows along y from
// the top of a mask downwards, and slices along z. A value; thread-safe as any value is.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

struct CavityGrid {
  double cell_mm = 0;  // side of a cell
  Point center{};      // middle of the grid, in the model's own millimetres
  double low_z = 0;    // the model's z at the underside of the lowest slice
  std::int32_t columns = 0, rows = 0, slices = 0;

  // Makes a grid around the bounds, with an empty cell at every side but below and above. A cell is a whole
  // multiple of `finest` and at least `least`, so large that there are at most `most_cells`, and at most
  // 16384 in a row; but at least 9.
  [[nodiscard]] static CavityGrid around(const Bounds& bounds, Millimeters finest, Millimeters least,
                                         double most_cells) {
    constexpr double kMostInRow = 16384, kFewest = 9;
    // Bounds the steps for a model of any size; below a million they go through all multiples.
    constexpr double kLeastGrowth = 1 + 1e-6;
    const double longest = std::max({bounds.size_x(), bounds.size_y(), bounds.size_z()});
    double multiple =
        std::max({std::ceil(least / finest), std::floor(longest / kMostInRow / finest.count()), 1.0});
    for (;; multiple = std::max(multiple + 1, std::floor(multiple * kLeastGrowth))) {
      const double cell = multiple * finest.count();
      const double columns = std::ceil(bounds.size_x() / cell) + 2;
      const double rows = std::ceil(bounds.size_y() / cell) + 2;
      const double slices = std::max(std::ceil(bounds.size_z() / cell), 1.0);
      if (columns * rows * slices > std::max(most_cells, kFewest)) continue;
      if (std::max({columns, rows, slices}) > kMostInRow) continue;
      return {cell,
              bounds.center(),
              bounds.min_z,
              static_cast<std::int32_t>(columns),
              static_cast<std::int32_t>(rows),
              static_cast<std::int32_t>(slices)};
    }
  }

  [[nodiscard]] std::size_t cells_in_slice() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  // Returns the display whose pixels are a slice's cells.
  [[nodiscard]] DisplayGeometry display() const {
    return {Pixels{columns}, Pixels{rows}, Micrometers{cell_mm * 1000}};
  }
  // Return coordinates of a cell's sides, in the model's own millimetres: the left side of a column, the
  // upper side of a row, the underside of a slice.
  [[nodiscard]] double left_of(std::int32_t column) const {
    return center.x + (column - columns / 2.0) * cell_mm;
  }
  [[nodiscard]] double top_of(std::int32_t row) const { return center.y + (rows / 2.0 - row) * cell_mm; }
  [[nodiscard]] double bottom_of(std::int32_t slice) const { return low_z + slice * cell_mm; }

  // Returns the slice at a z of the model's; it may be no slice of the grid.
  [[nodiscard]] double slice_at(Millimeters z) const { return std::floor((z.count() - low_z) / cell_mm); }
};

}  // namespace contourd
