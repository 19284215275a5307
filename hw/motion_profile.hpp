// A straight move's course over time: accelerate, cruise, decelerate; a trapezoid, or an S-curve where a jerk
// limit is given, and without the cruise when it is too short to reach full speed. Pure value, thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {

class MotionProfile {
 public:
  // A move over `distance` (its sign is the direction). The limits are a MotionCurve's.
  MotionProfile(Nanometers distance, MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration,
                std::optional<double> jerk_mm_s3 = std::nullopt);

  [[nodiscard]] Duration duration() const;

  // Displacement `elapsed` after the start: 0 before it, the whole distance after duration().
  [[nodiscard]] Nanometers displacement(Duration elapsed) const;

  // Decelerates to a standstill from `elapsed` after the start on: shortens the course that the others
  // describe. Does nothing when it is decelerating already.
  void stop_at(Duration elapsed);

 private:
  double sign_;
  MotionCurve curve_;  // in millimetres
};

}  // namespace contourd
