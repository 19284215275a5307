#include "core/support/support_primitive.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace contourd {
namespace {

// A frustum's axis, starting at the middle of its lower end.
struct Axis {
  double length;
  double rise, run;  // vertical and horizontal part of a unit step along the axis
  Point along;       // horizontal unit vector of the axis; arbitrary if the axis is vertical
};

Axis axis_of(const Frustum& frustum) {
  const double x = frustum.upper.x - frustum.lower.x, y = frustum.upper.y - frustum.lower.y;
  const double z = frustum.upper.z - frustum.lower.z;
  const double level = std::sqrt(x * x + y * y), length = std::sqrt(x * x + y * y + z * z);
  if (level == 0) return {length, z / length, 0, {1, 0}};
  return {length, z / length, level / length, {x / level, y / level}};
}

// Shrinks the cut's interval to where the term is not negative.
void keep_where_positive(const LinearTerm& term, ConicCut& cut) {
  if (term.b > 0) {
    cut.low = std::max(cut.low, -term.a / term.b);
  } else if (term.b < 0) {
    cut.high = std::min(cut.high, -term.a / term.b);
  } else if (term.a < 0) {
    cut.high = cut.low;
  }
}

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Coordinates in the plane: u runs horizontally from the middle of the lower end, in the direction of the
// axis, and v across it. The point (u, v) of the plane that lies `up` above the lower end is run u + rise up
// along the axis, where the radius is R, and its squared distance from the axis is v^2 + (rise u - run up)^2.
// So v^2 <= R^2 - (rise u - run up)^2, which is a product of two linear terms.
ConicCut cut_of(const Frustum& frustum, double z_mm) {
  const Axis axis = axis_of(frustum);
  const double up = z_mm - frustum.lower.z;
  const double widening = (frustum.upper_radius_mm - frustum.lower_radius_mm) / axis.length;
  const LinearTerm along{up * axis.rise, axis.run};
  const LinearTerm radius{frustum.lower_radius_mm + widening * along.a, widening * along.b};
  const LinearTerm off{-axis.run * up, axis.rise};
  ConicCut cut{{frustum.lower.x, frustum.lower.y},
               axis.along,
               -kInfinity,
               kInfinity,
               {radius.a + off.a, radius.b + off.b},
               {radius.a - off.a, radius.b - off.b},
               false};
  for (const LinearTerm& term : {cut.first, cut.second})
    keep_where_positive(term, cut);
  const double low = cut.low, high = cut.high;
  for (const LinearTerm& term : {along, LinearTerm{axis.length - along.a, -along.b}})
    keep_where_positive(term, cut);
  cut.whole = -kInfinity < low && low == cut.low && cut.high == high && high < kInfinity;
  // The interval is half-open: a horizontal upper end is not cut.
  if (axis.run == 0 && up >= axis.length) cut.high = cut.low;
  return cut;
}

ConicCut cut_of(const Ball& ball, double z_mm) {
  const double up = z_mm - ball.center.z;
  const double radius = std::sqrt(std::max(0.0, ball.radius_mm * ball.radius_mm - up * up));
  return {{ball.center.x, ball.center.y}, {1, 0}, -radius, radius, {radius, 1}, {radius, -1}, true};
}

}  // namespace

HeightReach reach_of(const SupportPrimitive& primitive) {
  if (const auto* ball = std::get_if<Ball>(&primitive))
    return {ball->center.z - ball->radius_mm, ball->center.z + ball->radius_mm};
  const auto& frustum = std::get<Frustum>(primitive);
  const double run = axis_of(frustum).run;
  const double lower = frustum.lower_radius_mm * run, upper = frustum.upper_radius_mm * run;
  return {std::min(frustum.lower.z - lower, frustum.upper.z - upper),
          std::max(frustum.lower.z + lower, frustum.upper.z + upper)};
}

std::optional<ConicCut> cut_at(const SupportPrimitive& primitive, double z_mm) {
  const ConicCut cut = std::visit([z_mm](const auto& each) { return cut_of(each, z_mm); }, primitive);
  if (!(cut.low < cut.high)) return std::nullopt;
  return cut;
}

}  // namespace contourd
