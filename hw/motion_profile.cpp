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

void MotionProfile::stop_at(Duration elapsed) {
  const double t = std::max(seconds(elapsed), 0.0);
  if (t >= ramp_s_ + cruise_s_) return;
  if (t < ramp_s_) {
    // Not yet at full speed: a triangle with its top here.
    top_mm_s_ = acceleration_mm_s2_ * t;
    ramp_s_ = t;
    cruise_s_ = 0;
  } else {
    cruise_s_ = t - ramp_s_;
  }
  distance_mm_ = top_mm_s_ * (ramp_s_ + cruise_s_);
}

}  // namespace contourd
