// A convex piece of a plane between two straight ends and a conic: an ellipse, a piece of an ellipse,
// parabola or hyperbola, or a rectangle. A value; thread-safe as any value is.
#pragma once

#include "core/contour/contour_loops.hpp"
#include "core/geometry/facet.hpp"

namespace contourd {

// The term a + b u.
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
  bool whole;  // a whole ellipse: each term is 0 at one end, and nothing is cut off

  // Returns how far the cut reaches to both sides at u.
  [[nodiscard]] double half_width_at(double u) const;
  // Returns the largest half width.
  [[nodiscard]] double half_width() const;
};

// Limits on an outline's corners: the distance of its sides from the true outline in mm, and the number of
// corners.
inline constexpr double kChordErrorMm = 0.001;
inline constexpr int kMostCorners = 1026;
// Adds the cut as a loop, counter-clockwise and convex. The corners lie on the outline, and the sides are at
// most kChordErrorMm from it; farther for cuts more than 400 mm wide, since a loop has at most kMostCorners.
// A cut without width adds nothing.
void append_outline(const ConicCut& cut, Contours& contours);

}  // namespace contourd
