#include "core/continuous/rise_plan.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// True if the points are those of a plan.
bool is_plan(const RisePlan& plan) {
  const std::vector<RisePoint>& points = plan.points;
  if (points.empty()) return true;
  if (points.size() < 3 || points.front().speed.count() != 0 || points.back().speed.count() != 0)
    return false;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].height <= points[i - 1].height) return false;
    if (i + 1 < points.size() && !(points[i].speed.count() > 0)) return false;
  }
  return true;
}

}  // namespace

RisePlan with_overrun(const RisePlan& plan) {
  expects(is_plan(plan), "a plan rises from rest to rest");
  if (plan.points.empty() || plan.overrun <= Nanometers{}) return {plan.points};
  RisePlan whole{plan.points};
  RisePoint top = whole.points.back(), ramp = *std::prev(whole.points.end(), 2);
  whole.points.back() = {ramp.height + plan.overrun, ramp.speed, top.limit};
  whole.points[whole.points.size() - 2].limit = plan.points[plan.points.size() - 3].limit;
  top.height += plan.overrun;
  whole.points.push_back(top);
  return whole;
}

std::chrono::duration<double> duration(const RisePoint& from, const RisePoint& to) {
  // The mean speed of a constant acceleration is the mean of its ends' speeds.
  return std::chrono::duration<double>(2 * in_mm(to.height - from.height) / (from.speed + to.speed).count());
}

std::chrono::duration<double> duration(const RisePlan& plan) {
  expects(is_plan(plan), "a plan rises from rest to rest");
  std::chrono::duration<double> sum{};
  for (std::size_t i = 1; i < plan.points.size(); ++i)
    sum += duration(plan.points[i - 1], plan.points[i]);
  return sum;
}

std::chrono::duration<double> duration(const RisePlan& plan, Nanometers low, Nanometers high) {
  std::chrono::duration<double> sum{};
  for (std::size_t i = 1; i < plan.points.size(); ++i) {
    const Nanometers from = std::max(low, plan.points[i - 1].height),
                     to = std::min(high, plan.points[i].height);
    if (from < to) sum += duration({from, speed_at(plan, from), {}}, {to, speed_at(plan, to), {}});
  }
  return sum;
}

MillimetersPerSecond speed_at(const RisePlan& plan, Nanometers height) {
  const auto above = std::ranges::upper_bound(plan.points, height, {}, &RisePoint::height);
  if (above == plan.points.begin() || above == plan.points.end()) return MillimetersPerSecond{};
  const RisePoint &from = *std::prev(above), &to = *above;
  const double part = in_mm(height - from.height) / in_mm(to.height - from.height);
  const double low = from.speed.count() * from.speed.count(), high = to.speed.count() * to.speed.count();
  return MillimetersPerSecond{std::sqrt(low + (high - low) * part)};
}

}  // namespace contourd
