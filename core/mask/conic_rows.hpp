// Finds the pixels whose centres lie in a conic cut, row by row. For a whole ellipse they come straight from
// its equation, with a square root for each row; for a cut with ends cut off they are those of its polygon
// (see ConvexRows).
//
// Not thread-safe; allocates only while polygons grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/contour/conic_cut.hpp"
#include "core/contract/expects.hpp"
#include "core/geometry/facet.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// Returns how many centres lie before a number, up to a limit.
[[nodiscard]] inline std::int32_t centers_before(double number, std::int32_t limit) {
  double held = number > 0 ? number : 0;
  held = held < limit ? held : limit;
  const auto whole = static_cast<std::int32_t>(held);
  return whole + static_cast<std::int32_t>(held - whole > 0.5);
}

// Finds the pixels whose centres lie in a convex polygon, row by row. A centre on a side is inside if the
// polygon lies right of the side, or below it for a level side, as for AntiAliasing::Off. Not thread-safe;
// allocates in its constructor only.
class ConvexRows {
 public:
  ConvexRows(Pixels width, Pixels height);

  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, from the top. The
  // polygon may lie anywhere, and run either way around. REQUIRES: at least one corner.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    expects(!corners.empty(), "a polygon has corners");
    const RowRange rows = find_ends(corners, map);
    for (std::int32_t row = rows.first; row < rows.end; ++row) {
      const Ends& ends = ends_[static_cast<std::size_t>(row)];
      const std::int32_t first = centers_before(ends.left, width_), end = centers_before(ends.right, width_);
      if (first < end) visit(row, first, end);
    }
  }

 private:
  struct RowRange {
    std::int32_t first, end;
  };
  // The columns where a row's centre line enters and leaves the polygon.
  struct Ends {
    double left = std::numeric_limits<double>::infinity();
    double right = -std::numeric_limits<double>::infinity();
  };

  [[nodiscard]] RowRange find_ends(std::span<const Point> corners, const PixelMap& map);
  void add_side(PixelPoint from, PixelPoint to);

  std::int32_t width_, height_;
  std::vector<Ends> ends_;  // by row
};

// An ellipse's pixels: in row `top + i` the columns [first[i], end[i]), none if end[i] <= first[i]. All of
// them lie in [left, right).
struct EllipseRows {
  std::int32_t top;
  std::span<const std::int32_t> first, end;
  std::int32_t left, right;
};

class ConicRows {
 public:
  ConicRows(Pixels width, Pixels height);

  // Returns the rows of a whole cut (see pixel_ellipse()). Valid until the next call.
  [[nodiscard]] EllipseRows ellipse(const ConicCut& cut, const PixelMap& map);
  // Calls `visit(row, first, end)` for the pixels [first, end) of each row that has any, from the top, of a
  // cut that is not whole.
  template <typename Visit>
  void visit(const ConicCut& cut, const PixelMap& map, Visit&& visit) {
    polygon_.points.clear();
    polygon_.loops.clear();
    append_outline(cut, polygon_);
    if (!polygon_.loops.empty()) polygons_.visit(polygon_.points, map, visit);
  }
  // Calls `visit` in the same way for a convex polygon.
  template <typename Visit>
  void visit(std::span<const Point> corners, const PixelMap& map, Visit&& visit) {
    polygons_.visit(corners, map, visit);
  }

 private:
  std::int32_t width_, height_;
  std::vector<std::int32_t> first_, end_;  // by row of an ellipse
  ConvexRows polygons_;
  Contours polygon_;
};

// An ellipse: at the height Y below its middle, a row's centre line is inside from lean Y - sqrt(flat - bend
// Y^2) to lean Y + sqrt(flat - bend Y^2), right of the middle.
struct PixelEllipse {
  PixelPoint middle;
  double lean, flat, bend;
  double reach_x, reach_y;  // largest extent to both sides
};

// Returns a whole cut as an ellipse; if it has no size, neither flat nor bend is above 0. REQUIRES:
// cut.whole.
[[nodiscard]] PixelEllipse pixel_ellipse(const ConicCut& cut, const PixelMap& map);

// The row ends of an ellipse: for row `top + i`, first[i] is the first column whose centre is inside, and
// end[i] the column after the last; equal if there is none.
struct RowEnds {
  std::span<std::int32_t> first, end;
};
// Fills `ends` for the rows from `top` on. `width`: the display's, in pixels. REQUIRES: first and end have
// the same length.
void find_row_ends(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);
// Does the same with the instructions that every processor has.
void find_row_ends_baseline(const PixelEllipse& ellipse, std::int32_t top, std::int32_t width, RowEnds ends);

}  // namespace contourd
