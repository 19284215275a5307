#include "hw/motion_profile.hpp"

#include <cmath>

namespace contourd {
namespace {

MotionLimits limits(MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration,
                    std::optional<double> jerk_mm_s3) {
  MotionLimits limits{speed.count(), acceleration.count()};
  if (jerk_mm_s3) limits.jerk = *jerk_mm_s3;
  return limits;
}

}  // namespace

MotionProfile::MotionProfile(Nanometers distance, MillimetersPerSecond speed,
                             MillimetersPerSecondSquared acceleration, std::optional<double> jerk_mm_s3)
    : sign_(distance < Nanometers{0} ? -1.0 : 1.0),
      curve_(std::fabs(to_millimeters(distance).count()), limits(speed, acceleration, jerk_mm_s3)) {}

Duration MotionProfile::duration() const {
  return Duration(static_cast<Duration::rep>(std::ceil(curve_.duration_s() * 1e9)));
}

Nanometers MotionProfile::displacement(Duration elapsed) const {
  return Nanometers{std::llround(sign_ * curve_.position_at(in_seconds(elapsed)) * 1e6)};
}

void MotionProfile::stop_at(Duration elapsed) {
  curve_.stop_at(in_seconds(elapsed));
}

}  // namespace contourd
