// Finds the outline of the area that contours fill: solids that overlap or share a wall become one, walls
// inside a solid disappear, loops that run the wrong way are turned. Afterwards no two loops cross and every
// side has the filled area on its left, which an offset needs.
//
// A loop that meets no other stays as it is. The sides of all others are cut where they meet (ArrangedSides);
// the pieces with the filled area on one side only are linked again.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/geometry/arranged_sides.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {

// The winding numbers that count as inside.
enum class FillRule { NonZero, Positive };

// Keeps its working memory between calls: allocates only while contours grow. Not thread-safe.
class ContourUnion {
 public:
  // The error of the points of a file's contours: 2^-15 mm. The coordinates are floats, rounded to 2^-17 mm
  // up to 128 mm; a vertex on another solid's wall misses the wall by about as much.
  static constexpr Millimeters kFileRounding{1.0 / (1 << 15)};
  // The error of contours that were calculated in doubles: a nanometre.
  static constexpr Millimeters kDoubleRounding{1.0 / (1 << 20)};

  // Replaces `outline` by the outline of `contours`; the cracks of `contours` are not carried over. Where
  // loops meet, points are rounded to multiples of `rounding`, or of more if the contours are wider than 2^30
  // times that. False if the budget was overrun: `outline` is then of no use. REQUIRES: two different
  // objects.
  [[nodiscard]] bool unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline,
                           MaskBudget& budget);
  // Unites without a limit on time. Throws std::length_error for more sides than a budget holds.
  void unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline);

  // True if the last contours wound around any point a negative number of times.
  [[nodiscard]] bool winds_negatively() const { return sides_.winds_negatively(); }

 private:
  using GridPoint = ArrangedSides::GridPoint;

  struct Loop {
    std::uint32_t first, count;  // in points_
    std::uint32_t side;          // one of the loop's sides, in sides_
    bool upwards;                // the loop runs up at that side
  };

  void choose_grid(const Contours& contours, Millimeters rounding);
  [[nodiscard]] GridPoint to_grid(Point point) const;
  [[nodiscard]] Point to_point(GridPoint point) const;
  void take_loop(std::span<const Point> points);
  void take_whole_loops(FillRule rule, Contours& outline) const;
  void take_cut_sides(FillRule rule);

  Point origin_{};
  double unit_ = 1;  // mm
  std::vector<Point> points_;
  std::vector<Loop> loops_;
  std::vector<GridPoint> corners_;
  ArrangedSides sides_;
  std::vector<Segment> kept_;
  ContourLinker linker_;
  Contours linked_;
};

}  // namespace contourd
