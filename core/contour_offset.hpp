// Moves contours outwards or inwards by a distance: the exact region of all points within it of the filled
// area, or farther than it inside, but for corners rounded in chords.
//
// Every side moves along its normal; where that opens a corner an arc closes it, where it closes one the
// moved sides are cut at their crossing, or run back to the corner itself when they are too short to have
// one. What the raw curve winds around a positive number of times is the moved region: every fault of the
// curve (a thin wall turned inside out, a hole that closes) winds 0 times or fewer, because each moved side
// only adds the strip that it passed over, or takes it away.
//
// Only + - * / and square roots: the same contours on every machine.
#pragma once

#include <vector>

#include "core/contour_loops.hpp"
#include "core/contour_union.hpp"
#include "core/units.hpp"

namespace contourd {

// Keeps its working memory between calls: allocates only while contours grow. Not thread-safe.
class ContourOffset {
 public:
  // How far the chord of an arc may lie from it: a hundredth of a pixel of 50 um.
  static constexpr Millimeters kChordError{0.0005};

  // Solids that overlap or touch are one before they are moved, so that no gap opens between them when they
  // shrink. Replaces `moved`; its loops do not cross, solids run counter-clockwise, holes clockwise.
  // `distance`: outwards; negative is inwards. REQUIRES: two different objects.
  void offset(const Contours& contours, Millimeters distance, Contours& moved);

 private:
  // A corner between two sides: directions and lengths.
  struct Corner {
    Point at;
    Point into, out_of;  // unit vectors along the side that comes and the side that goes
    double into_length, out_of_length;
  };

  void move_loop(std::span<const Point> points);
  void move_corner(const Corner& corner);
  void add_arc(Point center, Point from, Point to, Point between);
  void add(Point point) { raw_.points.push_back(point); }

  double distance_ = 0;
  std::vector<Point> corners_;
  ContourUnion union_;
  Contours outline_, raw_;
};

}  // namespace contourd
