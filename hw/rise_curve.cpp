#include "hw/rise_curve.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns half the difference of the squares of two neighbouring points' speeds: acceleration times distance.
double half_squares(const RisePoint& from, const RisePoint& to) {
  return (to.speed.count() - from.speed.count()) * (to.speed.count() + from.speed.count()) / 2;
}

// Returns the height at which a plate that starts at `from` with this acceleration, in mm/s^2, has the plan's
// speed, which is `speed` at `from`; nullopt if that is not below the plan's next point.
std::optional<Nanometers> where_joined(Nanometers from, MillimetersPerSecond speed, const RisePoint& next,
                                       double acceleration) {
  const double squared = speed.count() * speed.count(), length_mm = in_mm(next.height - from);
  const double growth = (next.speed.count() * next.speed.count() - squared) / length_mm;
  const double way_mm = squared / (2 * acceleration - growth);
  if (!(way_mm > 0 && way_mm < length_mm)) return std::nullopt;
  const Nanometers joined = from + Nanometers{static_cast<std::int64_t>(std::ceil(way_mm * 1e6))};
  return joined < next.height ? std::optional(joined) : std::nullopt;
}

}  // namespace

bool can_follow(const RisePlan& plan, MillimetersPerSecond top_speed,
                MillimetersPerSecondSquared acceleration) {
  const std::vector<RisePoint>& points = plan.points;
  if (points.size() < 3) return false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double speed = points[i].speed.count();
    const bool at_end = i == 0 || i + 1 == points.size();
    if (at_end ? speed != 0 : !(speed > 0 && speed <= top_speed.count())) return false;
    if (i == 0) continue;
    if (points[i].height <= points[i - 1].height) return false;
    constexpr double kRounding_mm = 1e-6;
    const double distance = in_mm(points[i].height - points[i - 1].height) + kRounding_mm;
    if (std::fabs(half_squares(points[i - 1], points[i])) > acceleration.count() * distance) return false;
  }
  return true;
}

RisePlan rest_of(const RisePlan& plan, Nanometers from) {
  expects(plan.points.size() > 2 && from >= plan.points.front().height, "the plan has begun");
  const Nanometers end = plan.points.back().height;
  RisePlan rest;
  if (end - from < kLeastRise) return rest;
  double most = 0;
  for (std::size_t i = 1; i < plan.points.size(); ++i) {
    const RisePoint &a = plan.points[i - 1], &b = plan.points[i];
    most = std::max(most, std::fabs(half_squares(a, b)) / in_mm(b.height - a.height));
  }
  const auto next = std::ranges::upper_bound(plan.points, from, {}, &RisePoint::height);
  rest.points.push_back({from, MillimetersPerSecond{}, std::prev(next)->limit});
  if (const auto joined = where_joined(from, speed_at(plan, from), *next, most)) {
    rest.points.push_back({*joined, speed_at(plan, *joined), std::prev(next)->limit});
  } else if (std::next(next) == plan.points.end()) {
    const Nanometers middle = from + (end - from) / 2;
    rest.points.push_back({middle, speed_at(plan, middle), std::prev(next)->limit});
  }
  rest.points.insert(rest.points.end(), next, plan.points.end());
  for (std::size_t i = 1; i + 1 < rest.points.size(); ++i) {
    const RisePoint& below = rest.points[i - 1];
    RisePoint& point = rest.points[i];
    const double squared =
        below.speed.count() * below.speed.count() + 2 * most * in_mm(point.height - below.height);
    point.speed = std::min(point.speed, MillimetersPerSecond{std::sqrt(squared)});
  }
  return rest;
}

RiseCurve::RiseCurve(const RisePlan& plan, double per_mm, double origin) {
  expects(plan.points.size() > 2, "a rise has points between its ends");
  points_.reserve(plan.points.size());
  double seconds = 0;
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    const RisePoint& point = plan.points[i];
    points_.push_back({seconds, in_mm(point.height) * per_mm - origin, point.speed.count() * per_mm, 0});
    if (i + 1 == plan.points.size()) break;
    const RisePoint& next = plan.points[i + 1];
    const double distance_mm = in_mm(next.height - point.height);
    points_.back().acceleration = half_squares(point, next) / distance_mm * per_mm;
    seconds += 2 * distance_mm / (point.speed.count() + next.speed.count());
  }
}

RiseCurve::State RiseCurve::at(double seconds) const noexcept {
  if (!(seconds > 0)) return {points_.front().position, 0, 0};
  if (seconds >= duration_s()) return {end(), 0, 0};
  const auto next = std::ranges::upper_bound(points_, seconds, {}, &Point::start_s);
  const Point& from = *std::prev(next);
  const double t = seconds - from.start_s;
  const double position = from.position + t * (from.speed + t * from.acceleration / 2);
  return {std::min(position, next->position), from.speed + t * from.acceleration, from.acceleration};
}

double RiseCurve::time_at(double position) const noexcept {
  if (position <= points_.front().position) return 0;
  if (position >= end()) return duration_s();
  const auto next = std::ranges::upper_bound(points_, position, {}, &Point::position);
  const Point& from = *std::prev(next);
  const double left = position - from.position;
  // The root of the parabola in the form that loses no digits.
  const double root = std::max(from.speed * from.speed + 2 * from.acceleration * left, 0.0);
  return std::min(from.start_s + 2 * left / (from.speed + std::sqrt(root)), next->start_s);
}

}  // namespace contourd
