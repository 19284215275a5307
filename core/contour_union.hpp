// The outline of what contours fill: solids that overlap or share a wall become one, walls inside a solid go,
// loops that run the wrong way are turned. After it no two loops cross and every side has the filled area on
// its left, which an offset needs.
//
// Sides that meet are found row by row and cut where they do; between two cuts a run of sides has the same on
// its left and on its right all along, so one look at the winding number on either side of it tells whether
// it is part of the outline. What is left of loops that were cut is linked again.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour_loops.hpp"

namespace contourd {

// Which winding numbers are inside.
enum class FillRule { NonZero, Positive };

// Keeps its working memory between calls: allocates only while contours grow. Not thread-safe.
class ContourUnion {
 public:
  // How far points of a file's contours lie off: 2^-15 mm. Its coordinates are floats, up to 128 mm rounded
  // to 2^-17 mm; where a vertex lies on another solid's wall it misses it by about as much.
  static constexpr Millimeters kFileRounding{1.0 / (1 << 15)};
  // The same for contours that were computed in doubles.
  static constexpr Millimeters kDoubleRounding{1.0 / (1 << 24)};

  // Replaces `outline` by the outline of `contours`; what contours say of gaps is not carried over. Points
  // nearer than the rounding are the same; walls and gaps thinner than twice of it do not show.
  // REQUIRES: two different objects.
  void unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline);

 private:
  struct Side {
    Point from, to;
    double low_x, high_x, low_y, high_y;
    std::uint32_t next;       // the side that follows in its loop
    std::uint32_t first_row;  // of those it lies in
    bool cut;                 // whether something meets the loop in `from`
  };
  struct Loop {
    std::uint32_t first, end;  // in sides_
  };
  // Where a side is cut, between its ends.
  struct Cut {
    std::uint32_t side;
    double along;  // 0 to 1
    Point point;
  };

  [[nodiscard]] bool same(Point a, Point b) const;
  void take_sides(const Contours& contours);
  void take_loop(std::span<const Point> points);
  void sort_into_rows();
  [[nodiscard]] std::uint32_t row_of(double y) const;
  void cut_where_sides_meet();
  void cut_pair(std::uint32_t a, std::uint32_t b);
  bool cut_by_end(std::uint32_t end_of, std::uint32_t other);
  void cut_by_crossing(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] int winding_at(Point point) const;
  [[nodiscard]] int direction_at(Point from, Point to, FillRule rule) const;
  // +1: filled on the left only, so part of the outline; -1: on the right only; 0: no part of it.
  [[nodiscard]] int outline_direction(std::span<const Point> run, FillRule rule) const;
  void take_whole_loop(const Loop& loop, FillRule rule, Contours& outline);
  void take_runs(const Loop& loop, FillRule rule);
  void take_run(std::span<const Point> run, FillRule rule);

  double same_ = 0;  // mm
  std::vector<Side> sides_;
  std::vector<Loop> loops_;
  std::vector<Cut> cuts_;
  double low_y_ = 0, rows_per_mm_ = 0;
  std::uint32_t rows_ = 0;
  std::vector<std::uint32_t> row_begin_, row_end_, in_rows_;  // sides by row
  std::vector<Point> run_;
  std::vector<std::uint32_t> run_ends_;  // in run_
  std::vector<Segment> kept_;
  ContourLinker linker_;
  Contours linked_;
};

}  // namespace contourd
