// A uniform grid of points: finds the points that may lie within a reach of a place. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// Keeps its memory between calls: allocates only while the points grow in number.
class PointGrid {
 public:
  // Sorts the chosen `points` into square cells of the reach's size, row by row: a cell and its neighbours
  // lie in three runs of three. REQUIRES: reach > 0.
  void sort(std::span<const Point> points, std::span<const std::uint32_t> chosen, double reach);

  // Calls visit(number) for the points that may lie within the reach of `place`, until it returns false; at
  // most `most_looks` times in a row of cells: the cost of a soup of coinciding points must not grow with the
  // square of its size.
  template <typename Visit>
  void visit_near(const Point& place, int most_looks, Visit&& visit) const {
    const Cell middle = cell_of(place, 0);
    for (const double row : {middle.row - 1, middle.row, middle.row + 1}) {
      const Cell first{row, middle.column - 1, 0};
      auto cell = std::lower_bound(cells_.begin(), cells_.end(), first);
      for (int looks = 0; looks < most_looks && cell != cells_.end(); ++looks, ++cell) {
        if (cell->row != row || cell->column > middle.column + 1) break;
        if (!visit(cell->number)) return;
      }
    }
  }

 private:
  struct Cell {
    double row, column;
    std::uint32_t number;
    bool operator<(const Cell& other) const {
      return std::tie(row, column, number) < std::tie(other.row, other.column, other.number);
    }
  };
  [[nodiscard]] Cell cell_of(const Point& point, std::uint32_t number) const;

  double cell_mm_ = 1;
  std::vector<Cell> cells_;
};

}  // namespace contourd
