// Random support primitives, from tips to feet, of any tilt (only within rc::check), and an independent test
// for points inside a primitive.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/support/support_primitive.hpp"
#include "tests/random_shapes.hpp"

namespace contourd::testing {

// Draws a frustum: one in four is upright, one in four horizontal; in one of four, one end is a point.
inline Frustum draw_frustum() {
  Frustum frustum;
  frustum.lower = {draw_real(-5, 5), draw_real(-5, 5), draw_real(0, 5)};
  frustum.upper = {draw_real(-5, 5), draw_real(-5, 5), frustum.lower.z + draw_real(0.1, 5)};
  const std::int64_t tilt = draw(0, 3);
  if (tilt == 0) frustum.upper = {frustum.lower.x, frustum.lower.y, frustum.upper.z};
  if (tilt == 1) frustum.upper = {frustum.lower.x + draw_real(0.1, 5), frustum.upper.y, frustum.lower.z};
  frustum.lower_radius_mm = draw_real(0.1, 2);
  frustum.upper_radius_mm = draw(0, 3) == 0 ? 0 : draw_real(0.1, 2);
  if (draw(0, 1) == 0) std::swap(frustum.lower_radius_mm, frustum.upper_radius_mm);
  return frustum;
}

inline SupportPrimitive draw_primitive() {
  if (draw(0, 4) > 0) return draw_frustum();
  return Ball{{draw_real(-5, 5), draw_real(-5, 5), draw_real(0, 5)}, draw_real(0.1, 2)};
}

struct Space {
  double x, y, z;
};
inline double dot(const Space& a, const Space& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Space between(const PlatePoint& from, const PlatePoint& to) {
  return {to.x - from.x, to.y - from.y, to.z - from.z};
}

// Returns how far a point is outside a primitive, in millimetres: at most its distance from the surface, and
// negative inside. Uses only the definition of a frustum: the distances across and along its axis.
inline double outside(const Frustum& frustum, const PlatePoint& point) {
  const Space axis = between(frustum.lower, frustum.upper), off = between(frustum.lower, point);
  const double length = std::sqrt(dot(axis, axis)), along = dot(axis, off) / length;
  const double across = std::sqrt(std::max(0.0, dot(off, off) - along * along));
  const double widening = (frustum.upper_radius_mm - frustum.lower_radius_mm) / length;
  const double from_side = (across - frustum.lower_radius_mm - widening * along) / std::hypot(1, widening);
  return std::max({from_side, -along, along - length});
}
inline double outside(const Ball& ball, const PlatePoint& point) {
  const Space off = between(ball.center, point);
  return std::sqrt(dot(off, off)) - ball.radius_mm;
}
inline double outside(const SupportPrimitive& primitive, const PlatePoint& point) {
  return std::visit([&](const auto& each) { return outside(each, point); }, primitive);
}

}  // namespace contourd::testing
