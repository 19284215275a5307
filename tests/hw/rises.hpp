// Plans of rises for tests, and their times by numerical integration, independent of RiseCurve.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/continuous/rise_plan.hpp"
#include "tests/random_shapes.hpp"

namespace contourd::testing {

// Limits that a drawn plan stays within.
struct RiseLimits {
  double speed_mm_s = 2;
  double acceleration_mm_s2 = 25;
};

inline RisePoint rise_point(double height_mm, double speed_mm_s) {
  return {Nanometers{std::llround(height_mm * 1e6)}, MillimetersPerSecond{speed_mm_s}, RiseLimit::Cure};
}

// Draws a plan that begins at `from`, of up to `most` points and a few millimetres.
inline RisePlan draw_rise(Nanometers from, std::int64_t most = 40, const RiseLimits& limits = {}) {
  RisePlan plan;
  Nanometers height = from;
  for (std::int64_t i = 0, count = draw(3, most); i < count; ++i) {
    plan.points.push_back(
        {height, MillimetersPerSecond{draw_real(0.05, limits.speed_mm_s)}, RiseLimit::Refill});
    height += Nanometers{draw(2'000, 200'000)};
  }
  plan.points.front().speed = plan.points.back().speed = MillimetersPerSecond{0};
  const auto limit = [&](RisePoint& point, const RisePoint& by) {
    const double way = std::fabs(in_mm(point.height - by.height));
    const double most_speed =
        std::sqrt(by.speed.count() * by.speed.count() + 2 * limits.acceleration_mm_s2 * way);
    point.speed = std::min(point.speed, MillimetersPerSecond{most_speed});
  };
  for (std::size_t i = 1; i < plan.points.size(); ++i)
    limit(plan.points[i], plan.points[i - 1]);
  for (std::size_t i = plan.points.size() - 1; i-- > 0;)
    limit(plan.points[i], plan.points[i + 1]);
  return plan;
}

// Returns the time in seconds at which the plan passes `height_mm`: the sum of dh / v by the midpoint rule.
// Towards an end at rest the slices are as short as the square of their distance from it.
inline double rise_time(const RisePlan& plan, double height_mm) {
  constexpr int kSlices = 400;
  double seconds = 0;
  for (std::size_t i = 1; i < plan.points.size(); ++i) {
    const RisePoint &a = plan.points[i - 1], &b = plan.points[i];
    const double low = in_mm(a.height), high = in_mm(b.height), top = std::min(high, height_mm);
    if (top <= low) break;
    const double from = a.speed.count() * a.speed.count(), to = b.speed.count() * b.speed.count();
    const bool rests_above = to < from;
    const auto place = [&](double u) {  // 0 at low, 1 at high
      return rests_above ? high - (high - low) * (1 - u) * (1 - u) : low + (high - low) * u * u;
    };
    const double share = (top - low) / (high - low);
    const double last = rests_above ? 1 - std::sqrt(1 - share) : std::sqrt(share);
    for (int k = 0; k < kSlices; ++k) {
      const double begin = place(last * k / kSlices), end = place(last * (k + 1) / kSlices);
      const double middle = place(last * (k + 0.5) / kSlices);
      seconds += (end - begin) / std::sqrt(from + (to - from) * (middle - low) / (high - low));
    }
  }
  return seconds;
}

}  // namespace contourd::testing
