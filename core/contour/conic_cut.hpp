// A convex piece of a plane between two straight ends and a conic: an ellipse, or a piece of one, of a
// parabola or a hyperbola; a rectangle. A value; thread-safe as any value is.
#pragma once

#include "core/contour/contour_loops.hpp"
#include "core/geometry/facet.hpp"

namespace contourd {

// a + b u.
struct LinearTerm {
  double a, b;
  [[nodiscard]] double at(double u) const { return a + b * u; }
};

// The points origin + u along + v across with low <= u <= high and v^2 <= first(u) second(u). In millimetres;
// `along` and `across` are unit vectors, across a quarter turn counter-clockwise from along. Both terms are
// at least 0, but for rounding, from low to high: their mean is what makes it convex.
struct ConicCut {
  Point origin, along;
  double low, high;
  LinearTerm first, second;
  bool whole;  // an ellipse: both terms are 0 at an end each, and nothing is cut off

  // How far it reaches to both sides at u.
  [[nodiscard]] double half_width_at(double u) const;
  // At its widest.
  [[nodiscard]] double half_width() const;
};

// Adds it as a loop, counter-clockwise and convex. Its corners are on the outline, at most kChordErrorMm
// from which its sides run; of cuts more than 400 mm wide farther, since there are at most kMostCorners.
// Nothing is added for a cut without width.
inline constexpr double kChordErrorMm = 0.001;
inline constexpr int kMostCorners = 1026;
void append_outline(const ConicCut& cut, Contours& contours);

}  // namespace contourd
