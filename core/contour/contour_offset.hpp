// Moves contours outwards or inwards by a distance: the exact region of all points within it of the filled
// area, or farther than it inside, but for corners rounded in chords.
//
// Every side moves along its normal; where that opens a corner an arc closes it, where it closes one the
// moved sides are cut at their crossing, or run back to the corner itself when they are too short to have
// one. What the raw curve winds around a positive number of times is the moved region: each moved side only
// adds the strip that it passed over, or takes it away. So what grows may overlap before, but what shrinks
// must be wound around once: a fault of the curve (a thin wall turned inside out) then winds 0 times or
// fewer.
//
// What is to shrink grows a little first. Solids that were drawn touching lie up to some rounding of the file
// apart (a micrometre and a half where coordinates have three decimals, less from a float far from its
// origin); moved as they are, the gap would open to twice the distance.
//
// Only + - * / and square roots: the same contours on every machine.
#pragma once

#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/contour_union.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// Keeps its working memory between calls: allocates only while contours grow. Not thread-safe.
class ContourOffset {
 public:
  // How far the chord of an arc may lie from it: a hundredth of a pixel of 50 um.
  static constexpr Millimeters kChordError{0.0005};

  // Gaps up to twice this are none to what shrinks (more than 4 m from the origin up to ten times this); a
  // corner inwards is rounded by it.
  static constexpr Millimeters kClosing{0.001};

  // Solids that overlap or touch are one before they are moved, so that no gap opens between them when they
  // shrink. Replaces `moved`; its loops do not cross, solids run counter-clockwise, holes clockwise.
  // `distance`: outwards; negative is inwards. False when the budget was overrun: `moved` is of no use then.
  // REQUIRES: two different objects.
  [[nodiscard]] bool offset(const Contours& contours, Millimeters distance, Contours& moved,
                            MaskBudget& budget);
  // The same with as much time as it takes. Throws std::length_error for more sides than a budget holds.
  void offset(const Contours& contours, Millimeters distance, Contours& moved);

 private:
  // How a corner that opens is closed.
  enum class Join { Round, Mitered };

  // A corner between two sides: directions and lengths.
  struct Corner {
    Point at;
    Point into, out_of;  // unit vectors along the side that comes and the side that goes
    double into_length, out_of_length;
  };

  // The region of all points within the distance, or farther than it inside.
  [[nodiscard]] bool move(const Contours& contours, double distance, Join join, Contours& moved,
                          MaskBudget& budget);
  // What shrinks: solids that overlap or touch as one.
  [[nodiscard]] bool close_gaps(const Contours& contours, double closing, MaskBudget& budget);
  void move_loop(std::span<const Point> points);
  void move_corner(const Corner& corner);
  void add_arc(Point center, Point from, Point to, Point between);
  void add(Point point) { raw_.points.push_back(point); }

  double distance_ = 0;
  Join join_ = Join::Round;
  std::vector<Point> corners_;
  ContourUnion union_;
  Contours outline_, closed_, raw_;
};

}  // namespace contourd
