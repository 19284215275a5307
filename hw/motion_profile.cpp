#include "hw/motion_profile.hpp"

#include <algorithm>
#include <cmath>

namespace contourd {
namespace {

double seconds(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}

Duration rounded_up(double s) {
  return Duration(static_cast<Duration::rep>(std::ceil(s * 1e9)));
}

Nanometers nanometers(double mm) {
  return Nanometers{std::llround(mm * 1e6)};
}

}  // namespace

MotionProfile::MotionProfile(Nanometers distance, MillimetersPerSecond speed,
                             MillimetersPerSecondSquared acceleration)
    : distance_mm_(std::fabs(to_millimeters(distance).count())),
      sign_(distance < Nanometers{0} ? -1.0 : 1.0),
      top_mm_s_(std::min(speed.count(), std::sqrt(distance_mm_ * acceleration.count()))),
      acceleration_mm_s2_(acceleration.count()),
      ramp_s_(top_mm_s_ / acceleration_mm_s2_),
      cruise_s_(distance_mm_ > 0 ? distance_mm_ / top_mm_s_ - ramp_s_ : 0.0) {}

Duration MotionProfile::duration() const {
  return rounded_up(2 * ramp_s_ + cruise_s_);
}

Nanometers MotionProfile::displacement(Duration elapsed) const {
  const double t = seconds(elapsed);
  const double total = 2 * ramp_s_ + cruise_s_;
  if (t <= 0) return Nanometers{0};
  if (t >= total) return nanometers(sign_ * distance_mm_);
  const double left = total - t;
  double mm = 0;
  if (t < ramp_s_) {
    mm = acceleration_mm_s2_ * t * t / 2;
  } else if (left < ramp_s_) {
    mm = distance_mm_ - acceleration_mm_s2_ * left * left / 2;
  } else {
    mm = top_mm_s_ * (t - ramp_s_ / 2);
  }
  return nanometers(sign_ * mm);
}

MotionProfile::EarlyStop MotionProfile::stopped_at(Duration elapsed) const {
  const double t = std::clamp(seconds(elapsed), 0.0, 2 * ramp_s_ + cruise_s_);
  const double left = 2 * ramp_s_ + cruise_s_ - t;
  // The speed now is that of the nearer ramp, or full; coming to rest from v takes v / a and v^2 / (2 a).
  const double speed = acceleration_mm_s2_ * std::min({t, left, ramp_s_});
  const double braking_mm = speed * speed / (2 * acceleration_mm_s2_);
  const double here_mm = to_millimeters(displacement(elapsed)).count();
  return {nanometers(here_mm + sign_ * braking_mm), rounded_up(t + speed / acceleration_mm_s2_)};
}

}  // namespace contourd
