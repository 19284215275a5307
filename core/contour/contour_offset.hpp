// Moves contours outwards or inwards by a distance; the contour engine corrects the size of layers with it.
// The result is the exact region of all points within the distance of the filled area, or inside it by more
// than the distance, except that round corners are made of chords.
//
// Every side moves along its normal. A corner that opens is closed by an arc; at a corner that closes, the
// moved sides are cut at their crossing, or run back to the corner itself if they are too short to cross. The
// moved region is the region that the raw curve winds around a positive number of times: each moved side only
// adds or removes the strip that it swept over. Contours that grow may therefore overlap each other. Contours
// that shrink must wind around their area exactly once: the raw curve then winds 0 times or fewer around
// areas that vanish, such as a thin wall whose sides have passed each other.
//
// Contours that shrink grow a little first. The file's rounding separates solids that were drawn touching, by
// a micrometre and a half for coordinates with three decimals; without the growth, that gap would widen by
// twice the distance.
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
  // The largest distance of a chord from its arc: a hundredth of a pixel of 50 um.
  static constexpr Millimeters kChordError{0.0005};

  // Gaps up to twice this width are closed before shrinking; more than 4 m from the origin, gaps up to ten
  // times this width. An inward corner is rounded with this radius.
  static constexpr Millimeters kClosing{0.001};

  // Moves the contours outwards by `distance`, or inwards if it is negative. Solids that overlap or touch are
  // united first, so that no gap opens between them when they shrink. Replaces `moved`; its loops do not
  // cross, solids run counter-clockwise, holes clockwise. Returns false if the budget was overrun; `moved` is
  // then incomplete. REQUIRES: two different objects.
  [[nodiscard]] bool offset(const Contours& contours, Millimeters distance, Contours& moved,
                            MaskBudget& budget);
  // Moves the contours without a limit on time. Throws std::length_error for more sides than a budget holds.
  void offset(const Contours& contours, Millimeters distance, Contours& moved);

 private:
  // The shape that closes a corner that opens.
  enum class Join { Round, Mitered };

  // A corner between two sides: directions and lengths.
  struct Corner {
    Point at;
    Point into, out_of;  // unit vectors along the arriving and the leaving side
    double into_length, out_of_length;
  };

  // Finds the region of all points within the distance, or of all points inside by more than the distance.
  [[nodiscard]] bool move(const Contours& contours, double distance, Join join, Contours& moved,
                          MaskBudget& budget);
  // Prepares contours for shrinking: unites solids that overlap or touch, and grows them.
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
