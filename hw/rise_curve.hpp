// A rise of the plate over time: the path of a RisePlan, in any unit of length. Immutable, so thread-safe.
// The constructor allocates; the queries neither allocate nor throw, so that real-time threads may use them.
//
// Between two points at heights h0 and h1 with speeds v0 and v1 the acceleration is a = (v1^2 - v0^2) / 2(h1
// - h0), and the plate takes 2(h1 - h0) / (v0 + v1).
#pragma once

#include <cstddef>
#include <vector>

#include "core/continuous/rise_plan.hpp"

namespace contourd {

// True if the plan is one that an axis can follow: at least three points, heights that rise strictly, speeds
// of 0 at both ends and above 0 in between, and speeds and accelerations within the limits. Allows for
// heights rounded to whole nanometres.
[[nodiscard]] bool can_follow(const RisePlan& plan, MillimetersPerSecond top_speed,
                              MillimetersPerSecondSquared acceleration);

// A shorter rest of a rise is not worth a motion.
inline constexpr Nanometers kLeastRise{10'000};
// Returns the plan from a height on, at which the plate is at rest: never faster than the plan, and with no
// more than its largest acceleration. Has no points if less than kLeastRise is left. REQUIRES: a plan as in
// RisePlan, with points; `from` is not below the first one.
[[nodiscard]] RisePlan rest_of(const RisePlan& plan, Nanometers from);

class RiseCurve {
 public:
  struct State {
    double position = 0, speed = 0, acceleration = 0;
  };

  // Makes the curve of a plan, with `per_mm` units of length a millimetre, and position 0 at `origin` units
  // above height 0. REQUIRES: can_follow() with some limits.
  RiseCurve(const RisePlan& plan, double per_mm, double origin);

  [[nodiscard]] double duration_s() const noexcept { return points_.back().start_s; }
  // Returns the position of the plan's last point.
  [[nodiscard]] double end() const noexcept { return points_.back().position; }
  // Returns the state at a time; the curve is at rest before the start and after the end.
  [[nodiscard]] State at(double seconds) const noexcept;
  // Returns the time at which the curve passes `position`: 0 below the first point, duration_s() above the
  // last.
  [[nodiscard]] double time_at(double position) const noexcept;

 private:
  // A point of the plan, and the acceleration from there to the next.
  struct Point {
    double start_s, position, speed, acceleration;
  };

  std::vector<Point> points_;
};

}  // namespace contourd
