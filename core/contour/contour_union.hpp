// The outline of what contours fill: solids that overlap or share a wall become one, walls inside a solid go,
// loops that run the wrong way are turned. After it no two loops cross and every side has the filled area on
// its left, which an offset needs.
//
// A loop that nothing meets stays as it is. Of the others, the sides are cut where they meet (ArrangedSides);
// those with the filled area on one side only are linked again.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/geometry/arranged_sides.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {

// Which winding numbers are inside.
enum class FillRule { NonZero, Positive };

// Keeps its working memory between calls: allocates only while contours grow. Not thread-safe.
class ContourUnion {
 public:
  // How far points of a file's contours lie off: 2^-15 mm. Its coordinates are floats, up to 128 mm rounded
  // to 2^-17 mm; where a vertex lies on another solid's wall it misses it by about as much.
  static constexpr Millimeters kFileRounding{1.0 / (1 << 15)};
  // The same for contours that were computed in doubles: a nanometre.
  static constexpr Millimeters kDoubleRounding{1.0 / (1 << 20)};

  // Replaces `outline` by the outline of `contours`; what contours say of gaps is not carried over. Where
  // loops meet, points are rounded to multiples of `rounding`, or of more where the contours are wider than
  // 2^30 of it. False when the budget was overrun: `outline` is of no use then.
  // REQUIRES: two different objects.
  [[nodiscard]] bool unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline,
                           MaskBudget& budget);
  // The same with as much time as it takes. Throws std::length_error for more sides than a budget holds.
  void unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline);

  // Whether the last contours wound around anything a negative number of times.
  [[nodiscard]] bool winds_negatively() const { return sides_.winds_negatively(); }

 private:
  using GridPoint = ArrangedSides::GridPoint;

  struct Loop {
    std::uint32_t first, count;  // in points_
    std::uint32_t side;          // one of its own, in sides_
    bool upwards;                // whether it runs up there
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
