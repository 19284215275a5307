// A straight move's course over time: accelerate, cruise, decelerate (trapezoid; a triangle when it is too
// short to reach full speed). Pure value, thread-safe.
//
// With acceleration a, top speed v and distance d: the ramps take v/a and v^2/(2a) each; when v^2/a > d, the
// top speed is sqrt(d a).
#pragma once

#include <cstdint>

#include "core/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

class MotionProfile {
 public:
  // A move over `distance` (its sign is the direction). REQUIRES: speed > 0, acceleration > 0.
  MotionProfile(Nanometers distance, MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration);

  [[nodiscard]] Duration duration() const;

  // Displacement `elapsed` after the start: 0 before it, the whole distance after duration().
  [[nodiscard]] Nanometers displacement(Duration elapsed) const;

  // Decelerates to a standstill from `elapsed` after the start on: shortens the course that the others
  // describe. Does nothing when it is decelerating already.
  void stop_at(Duration elapsed);

 private:
  double distance_mm_;
  double sign_;
  double top_mm_s_;
  double acceleration_mm_s2_;
  double ramp_s_;
  double cruise_s_;  // at full speed
};

}  // namespace contourd
