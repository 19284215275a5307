// A straight move over time: accelerate, cruise, decelerate. The speed is a trapezoid, or an S-curve where a
// jerk limit is given; a move too short to reach full speed has no cruise. Pure value, thread-safe.
#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {

class MotionProfile {
 public:
  // Plans a move over `distance`, whose sign is the direction. The limits are those of a MotionCurve.
  MotionProfile(Nanometers distance, MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration,
                std::optional<double> jerk_mm_s3 = std::nullopt);

  [[nodiscard]] Duration duration() const;

  // Returns the displacement `elapsed` after the start: 0 before the start, the whole distance after
  // duration().
  [[nodiscard]] Nanometers displacement(Duration elapsed) const;

  // Decelerates to a standstill from `elapsed` after the start on, which changes duration() and
  // displacement(). Does nothing if the move is already decelerating by then.
  void stop_at(Duration elapsed);

 private:
  double sign_;
  MotionCurve curve_;  // in millimetres
};

}  // namespace contourd
