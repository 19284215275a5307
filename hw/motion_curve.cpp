#include "hw/motion_curve.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

bool jerks(const MotionLimits& limits) {
  return std::isfinite(limits.jerk);
}

// Returns how long a ramp from rest to `speed` takes.
double ramp_s(double speed, const MotionLimits& limits) {
  const double rise_s = limits.acceleration / limits.jerk;
  const double full =
      limits.acceleration * rise_s;  // the speed from which on a ramp reaches the acceleration limit
  return speed >= full ? speed / limits.acceleration + rise_s : 2 * std::sqrt(speed / limits.jerk);
}

// Returns the top speed at which ramping up and down again takes the whole distance.
double peak_speed(double distance, const MotionLimits& limits) {
  const double a = limits.acceleration;
  if (!jerks(limits)) return std::sqrt(distance * a);
  const double rise_s = a / limits.jerk;
  const double with_hold = a * (std::sqrt(rise_s * rise_s + 4 * distance / a) - rise_s) / 2;
  if (with_hold >= a * rise_s) return with_hold;
  return std::cbrt(distance * distance * limits.jerk / 4);
}

// Returns the time t at which v t + a t^2/2 + j t^3/6 is `position`, for a position that is reached within
// `longest` without turning back. Newton's method, which halves the bracket whenever a step leaves it.
double cubic_time(double position, double speed, double acceleration, double jerk, double longest) {
  double low = 0, high = longest;
  const double root = std::max(speed * speed + 2 * acceleration * position, 0.0);
  const double slope = speed + std::sqrt(root);
  double t = slope > 0 ? 2 * position / slope
                       : std::cbrt(6 * position / jerk);  // ignoring the jerk; from a standstill
  if (!(t > low && t < high)) t = high / 2;
  constexpr int kEnough = 60;  // halving alone would have converged to rounding by then
  for (int i = 0; i < kEnough; ++i) {
    const double excess = t * (speed + t * (acceleration / 2 + t * jerk / 6)) - position;
    (excess > 0 ? high : low) = t;
    const double velocity = speed + t * (acceleration + t * jerk / 2);
    double next = velocity > 0 ? t - excess / velocity : low;
    if (!(next > low && next < high)) next = (low + high) / 2;
    constexpr double kClose = 1e-11;  // seconds: a hundredth of the nanosecond to which times are rounded
    if (std::fabs(next - t) <= kClose) return next;
    t = next;
  }
  return t;
}

MotionLimits limits(MillimetersPerSecond speed, MillimetersPerSecondSquared acceleration,
                    std::optional<double> jerk_mm_s3) {
  MotionLimits limits{speed.count(), acceleration.count()};
  if (jerk_mm_s3) limits.jerk = *jerk_mm_s3;
  return limits;
}

}  // namespace

MotionCurve::MotionCurve(double distance, const MotionLimits& limits) noexcept : limits_(limits) {
  expects(distance >= 0, "the distance is not negative");
  expects(limits.speed > 0 && limits.acceleration > 0 && limits.jerk > 0, "every limit is positive");
  if (!(distance > 0)) return;
  const double speed = std::min(limits.speed, peak_speed(distance, limits));
  add_ramp(speed, 1);
  const double cruise = distance - speed * ramp_s(speed, limits);
  if (cruise > 0) add(cruise / speed, 0, 0);
  add_ramp(speed, -1);
  pieces_[count_].position = distance;
  pieces_[count_].speed = 0;
}

// A rise precedes the pieces, of which there are none until it is stopped. So moves without a rise cost no
// more than if there were no rises.
MotionCurve::MotionCurve(const RiseCurve& rise, const MotionLimits& limits) noexcept
    : limits_(limits), rise_(&rise) {
  expects(limits.speed > 0 && limits.acceleration > 0 && limits.jerk > 0, "every limit is positive");
  pieces_[0].start_s = rise.duration_s();
  pieces_[0].position = rise.end();
}

void MotionCurve::add(double seconds, double acceleration, double jerk) noexcept {
  Piece& piece = pieces_[count_];
  piece.acceleration = acceleration;
  piece.jerk = jerk;
  pieces_[count_ + 1] = Piece{after(piece, seconds), 0};
  ++count_;
  pieces_[count_].acceleration = 0;
}

void MotionCurve::add_ramp(double change, double sign) noexcept {
  const double a = sign * limits_.acceleration, j = sign * limits_.jerk;
  if (!jerks(limits_)) return add(change / limits_.acceleration, a, 0);
  const double rise_s = limits_.acceleration / limits_.jerk;
  if (change >= limits_.acceleration * rise_s) {
    add(rise_s, 0, j);
    add(change / limits_.acceleration - rise_s, a, 0);
    add(rise_s, a, -j);
  } else {
    const double half_s = std::sqrt(change / limits_.jerk);
    add(half_s, 0, j);
    add(half_s, j * half_s, -j);
  }
}

MotionCurve::State MotionCurve::after(const Piece& piece, double t) noexcept {
  return {piece.start_s + t,
          piece.position + t * (piece.speed + t * (piece.acceleration / 2 + t * piece.jerk / 6)),
          piece.speed + t * (piece.acceleration + t * piece.jerk / 2), piece.acceleration + t * piece.jerk};
}

std::size_t MotionCurve::piece_at(double seconds) const noexcept {
  std::size_t i = 0;
  while (i < count_ && pieces_[i + 1].start_s <= seconds)
    ++i;
  return i;
}

double MotionCurve::position_at(double seconds) const noexcept {
  if (follows_rise(seconds)) return rise_->at(seconds).position;
  if (seconds <= 0) return 0;
  const std::size_t i = piece_at(seconds);
  if (i == count_) return end().position;
  return std::min(after(pieces_[i], seconds - pieces_[i].start_s).position, end().position);
}

double MotionCurve::speed_at(double seconds) const noexcept {
  if (follows_rise(seconds)) return rise_->at(seconds).speed;
  const std::size_t i = piece_at(seconds);
  if (seconds <= 0 || i == count_) return 0;
  return after(pieces_[i], seconds - pieces_[i].start_s).speed;
}

double MotionCurve::time_at(double position) const noexcept {
  std::size_t i = 0;
  while (i < count_ && pieces_[i + 1].position < position)
    ++i;
  const Piece& piece = pieces_[i];
  if (i == count_) return count_ == 0 && rise_ != nullptr ? rise_->time_at(position) : piece.start_s;
  const double left = std::max(position - piece.position, 0.0),
               longest = pieces_[i + 1].start_s - piece.start_s;
  if (left == 0) return rise_ != nullptr ? rise_->time_at(position) : piece.start_s;
  if (piece.jerk != 0) {
    return piece.start_s + cubic_time(left, piece.speed, piece.acceleration, piece.jerk, longest);
  }
  // The root of the parabola in the form that loses no digits; without acceleration, a straight line's.
  const double root = std::max(piece.speed * piece.speed + 2 * piece.acceleration * left, 0.0);
  return piece.start_s + std::min(2 * left / (piece.speed + std::sqrt(root)), longest);
}

void MotionCurve::stop_at(double seconds) noexcept {
  if (stopping_) return;
  if (follows_rise(seconds)) {
    const RiseCurve::State now = rise_->at(seconds);
    return stop_from({std::max(seconds, 0.0), now.position, now.speed, now.acceleration});
  }
  const std::size_t i = piece_at(std::max(seconds, 0.0));
  if (i == count_) return;
  const Piece& piece = pieces_[i];
  if (piece.acceleration < 0 || (piece.acceleration == 0 && piece.jerk < 0)) return;
  count_ = i + 1;
  stop_from(after(piece, std::max(seconds, 0.0) - piece.start_s));
}

// Replaces everything after the first count_ pieces by slowing down to rest.
void MotionCurve::stop_from(const State& now) noexcept {
  stopping_ = true;
  pieces_[count_] = Piece{now, 0};
  const double still_speeding_up = std::max(now.acceleration, 0.0);
  if (jerks(limits_) && still_speeding_up > 0) {
    add(still_speeding_up / limits_.jerk, still_speeding_up, -limits_.jerk);
  }
  add_ramp(end().speed, -1);
  pieces_[count_].speed = 0;
}

MotionProfile::MotionProfile(Nanometers distance, MillimetersPerSecond speed,
                             MillimetersPerSecondSquared acceleration, std::optional<double> jerk_mm_s3)
    : sign_(distance < Nanometers{0} ? -1.0 : 1.0),
      curve_(std::fabs(to_millimeters(distance).count()), limits(speed, acceleration, jerk_mm_s3)) {}

MotionProfile::MotionProfile(const RiseCurve& rise, MillimetersPerSecondSquared acceleration)
    : sign_(1), curve_(rise, limits(MillimetersPerSecond{1}, acceleration, std::nullopt)) {}

Duration MotionProfile::duration() const {
  return Duration(static_cast<Duration::rep>(std::ceil(curve_.duration_s() * 1e9)));
}

Nanometers MotionProfile::displacement(Duration elapsed) const {
  return Nanometers{std::llround(sign_ * curve_.position_at(in_seconds(elapsed)) * 1e6)};
}

}  // namespace contourd
