#include "hw/motion_curve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/random_shapes.hpp"

using namespace contourd;
using testing::Approx;
using testing::draw;
using testing::draw_real;
using namespace std::chrono_literals;
using testing::mm;

namespace {

struct DrawnCurve {
  double distance;
  MotionLimits limits;
  [[nodiscard]] MotionCurve curve() const { return {distance, limits}; }
};

// Draws a plate's move in millimetres or in microsteps, with or without a jerk limit.
DrawnCurve draw_curve() {
  const double scale = *rc::gen::element(1.0, 800.0);
  DrawnCurve move{draw_real(0.0001, 200) * scale, {draw_real(0.1, 50) * scale, draw_real(1, 500) * scale}};
  if (draw(0, 2) != 0) move.limits.jerk = draw_real(5, 20000) * scale;
  return move;
}

// Tolerance for rounding: doubles carry 53 bits; a curve adds up to ten pieces, some with a root or a cube
// root.
constexpr double kRounding = 1e-9;

// Samples the curve and asserts that speed, acceleration and jerk do not exceed the limits.
void assert_within_limits(const MotionCurve& curve, const MotionLimits& limits) {
  constexpr int kSamples = 400;
  const double step = curve.duration_s() / kSamples;
  double last_acceleration = 0, last_speed = 0;
  for (int i = 1; i <= kSamples; ++i) {
    // Mean values over a sample's time: those of quantities within limits are within the limits, too.
    const double speed = curve.speed_at(i * step), acceleration = (speed - last_speed) / step;
    const double noise = kRounding * limits.speed / step;
    RC_ASSERT(speed <= limits.speed * (1 + kRounding));
    RC_ASSERT(std::fabs(acceleration) <= limits.acceleration + noise);
    if (i > 1 && std::isfinite(limits.jerk)) {
      RC_ASSERT(std::fabs(acceleration - last_acceleration) / step <=
                limits.jerk * (1 + kRounding) + 2 * noise / step);
    }
    last_speed = speed;
    last_acceleration = acceleration;
  }
}

// The end of a move that is stopped early.
struct EarlyStop {
  Nanometers displacement;
  Duration duration;
};

EarlyStop stopped_at(MotionProfile profile, Duration elapsed) {
  profile.stop_at(elapsed);
  return {profile.displacement(profile.duration()), profile.duration()};
}

MotionProfile profile(double distance_mm, double speed_mm_s, double acceleration_mm_s2) {
  return {mm(distance_mm), MillimetersPerSecond{speed_mm_s}, MillimetersPerSecondSquared{acceleration_mm_s2}};
}

// True if the duration is `seconds`. The tolerance is a nanosecond for rounding up, and the rounding of a
// double of seconds below 1e5: 1e-11 s.
bool lasts(Duration duration, double seconds) {
  return std::fabs(in_seconds(duration) - seconds) <= 1e-9 + 1e-11;
}

struct DrawnProfile {
  double distance_mm, speed, acceleration;
  [[nodiscard]] MotionProfile profile() const { return ::profile(distance_mm, speed, acceleration); }
};

DrawnProfile draw_profile() {
  return {draw_real(-200, 200), draw_real(0.1, 50), draw_real(1, 500)};
}

Duration draw_time(const MotionProfile& p) {
  return Duration{draw(0, p.duration().count())};
}

}  // namespace

TEST_CASE("A jerk-limited ramp that reaches its acceleration takes v/A + A/J") {
  // A/J = 0.1 s, v/A = 0.4 s: 0.5 s and 2.5 mm a ramp, 5 mm in between at 10 mm/s.
  const MotionCurve curve(10, {10, 25, 250});
  CHECK(curve.duration_s() == Approx(0.5 + 0.5 + 0.5).margin(kRounding));
  CHECK(curve.position_at(0.5) == Approx(2.5).margin(kRounding));
  CHECK(curve.position_at(0.1) == Approx(250 * 0.001 / 6).margin(kRounding));
  CHECK(curve.speed_at(0.1) == Approx(1.25).margin(kRounding));
  CHECK(curve.speed_at(0.25) == Approx(5).margin(kRounding));
  CHECK(curve.speed_at(0.75) == Approx(10).margin(kRounding));
}

TEST_CASE("A jerk-limited ramp too short for its acceleration takes 2 sqrt(v/J)") {
  const MotionCurve curve(10, {10, 1000, 250});
  // 2 sqrt(10/250) = 0.4 s and 2 mm a ramp, 6 mm at 10 mm/s.
  CHECK(curve.duration_s() == Approx(0.4 + 0.6 + 0.4).margin(kRounding));
}

TEST_CASE("A move too short for any hold peaks at the cube root of D^2 J / 4") {
  const MotionCurve curve(2, {1000, 1000, 1});
  CHECK(curve.speed_at(curve.duration_s() / 2) == Approx(1).margin(kRounding));
  CHECK(curve.duration_s() == Approx(4).margin(kRounding));
}

TEST_CASE("A curve starts and ends at rest and goes its whole distance") {
  CHECK(rc::check([] {
    const DrawnCurve move = draw_curve();
    const MotionCurve curve = move.curve();
    RC_ASSERT(curve.position_at(0) == 0.0);
    RC_ASSERT(curve.position_at(-1) == 0.0);
    RC_ASSERT(curve.position_at(curve.duration_s()) == move.distance);
    RC_ASSERT(curve.position_at(curve.duration_s() + 1) == move.distance);
    // The last picosecond before the end moves next to nothing: the pieces meet the distance by themselves.
    RC_ASSERT(std::fabs(curve.position_at(std::nextafter(curve.duration_s(), 0.0)) - move.distance) <=
              kRounding * move.distance);
    RC_ASSERT(std::fabs(curve.speed_at(std::nextafter(curve.duration_s(), 0.0))) <=
              1e-6 *
                  move.limits.speed);  // sqrt of the rounding: speed goes with the root of the distance left
  }));
}

TEST_CASE("A curve keeps within its speed, its acceleration and its jerk") {
  CHECK(rc::check([] {
    const DrawnCurve move = draw_curve();
    const MotionCurve curve = move.curve();
    assert_within_limits(curve, move.limits);
    constexpr int kSamples = 400;
    for (int i = 1; i <= kSamples; ++i)
      RC_ASSERT(curve.speed_at(i * curve.duration_s() / kSamples) >= -kRounding * move.limits.speed);
  }));
}

TEST_CASE("A curve's second half mirrors its first") {
  CHECK(rc::check([] {
    const DrawnCurve move = draw_curve();
    const MotionCurve curve = move.curve();
    const double t = curve.duration_s() * draw_real(0, 1);
    RC_ASSERT(std::fabs(curve.position_at(t) + curve.position_at(curve.duration_s() - t) - move.distance) <=
              kRounding * move.distance);
  }));
}

TEST_CASE("The time at a position is the inverse of the position at a time") {
  CHECK(rc::check([] {
    const DrawnCurve move = draw_curve();
    const MotionCurve curve = move.curve();
    const double part = move.distance * draw_real(0, 1);
    RC_ASSERT(std::fabs(curve.position_at(curve.time_at(part)) - part) <= kRounding * move.distance);
    RC_ASSERT(curve.time_at(move.distance * 2) == curve.duration_s());
    RC_ASSERT(curve.time_at(0) == 0.0);
  }));
}

TEST_CASE("A jerk limit makes no move quicker") {
  CHECK(rc::check([] {
    DrawnCurve move = draw_curve();
    const double with_jerk = move.curve().duration_s();
    move.limits.jerk = MotionLimits{}.jerk;
    RC_ASSERT(move.curve().duration_s() <= with_jerk * (1 + kRounding));
  }));
}

TEST_CASE("A stop comes to rest within the limits and not beyond the end") {
  CHECK(rc::check([] {
    const DrawnCurve move = draw_curve();
    const MotionCurve whole = move.curve();
    MotionCurve curve = whole;
    const double at = whole.duration_s() * draw_real(0, 1);
    curve.stop_at(at);
    const MotionCurve stopped = curve;
    curve.stop_at(at + (curve.duration_s() - at) * draw_real(0, 1));
    RC_ASSERT(curve.distance() == stopped.distance());  // a second stop changes nothing
    RC_ASSERT(std::fabs(curve.position_at(at) - whole.position_at(at)) <= kRounding * move.distance);
    RC_ASSERT(curve.distance() <= move.distance * (1 + kRounding));
    RC_ASSERT(curve.duration_s() <= whole.duration_s() * (1 + kRounding));
    assert_within_limits(curve, move.limits);
  }));
}

TEST_CASE("A long move ramps up and cruises and ramps down") {
  // v/a = 0.4 s and v^2/2a = 2 mm for each ramp, 36 mm at 10 mm/s.
  const MotionProfile p = profile(40, 10, 25);
  CHECK(lasts(p.duration(), 0.4 + 3.6 + 0.4));
  CHECK(p.displacement(200ms) == mm(0.5));
  CHECK(p.displacement(400ms) == mm(2));
  CHECK(p.displacement(2200ms) == mm(20));
  CHECK(p.displacement(4000ms) == mm(38));
  CHECK(p.displacement(4200ms) == mm(39.5));
  CHECK(p.displacement(p.duration()) == mm(40));
}

TEST_CASE("A short move never reaches full speed") {
  // Top speed sqrt(d a) = 5 mm/s after 0.2 s and half a millimetre.
  const MotionProfile p = profile(1, 10, 25);
  CHECK(lasts(p.duration(), 0.4));
  CHECK(p.displacement(100ms) == mm(0.125));
  CHECK(p.displacement(200ms) == mm(0.5));
  CHECK(p.displacement(300ms) == mm(0.875));
}

TEST_CASE("A move that just reaches full speed has no cruise") {
  const MotionProfile p = profile(4, 10, 25);
  CHECK(lasts(p.duration(), 0.8));
  CHECK(p.displacement(400ms) == mm(2));
}

TEST_CASE("A move over no distance takes no time") {
  const MotionProfile p = profile(0, 10, 25);
  CHECK(p.duration() == Duration{0});
  CHECK(p.displacement(1s) == Nanometers{0});
  CHECK(stopped_at(p, 0s).displacement == Nanometers{0});
  CHECK(stopped_at(p, 1s).duration == Duration{0});
}

TEST_CASE("A move over one nanometre arrives") {
  const MotionProfile p{Nanometers{1}, MillimetersPerSecond{10}, MillimetersPerSecondSquared{25}};
  CHECK(p.displacement(p.duration()) == Nanometers{1});
  CHECK(p.duration() > Duration{0});
}

TEST_CASE("Before its start a move stands still and after its end at its whole distance") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    RC_ASSERT(p.displacement(Duration{-draw(0, 1'000'000'000)}) == Nanometers{0});
    RC_ASSERT(p.displacement(p.duration() + Duration{draw(0, 1'000'000'000)}) == mm(move.distance_mm));
    RC_ASSERT(p.displacement(p.duration()) == mm(move.distance_mm));
  }));
}

TEST_CASE("A move never goes back and never faster than its speed") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    Duration one = draw_time(p), other = draw_time(p);
    if (other < one) std::swap(one, other);
    const double sign = move.distance_mm < 0 ? -1.0 : 1.0;
    const double distance_nm =
        sign * static_cast<double>((p.displacement(other) - p.displacement(one)).count());
    RC_ASSERT(distance_nm >= 0.0);
    const double seconds = std::chrono::duration<double>(other - one).count();
    // Both ends are rounded to whole nanometres.
    RC_ASSERT(distance_nm <= move.speed * seconds * 1e6 + 1.0);
  }));
}

TEST_CASE("A move's second half mirrors its first") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    const Duration t = draw_time(p);
    const std::int64_t sum = (p.displacement(t) + p.displacement(p.duration() - t)).count();
    // Two roundings to a nanometre, and the distance in the nanosecond by which the duration is rounded up.
    RC_ASSERT(std::llabs(sum - mm(move.distance_mm).count()) <= 2);
  }));
}

TEST_CASE("A move has the duration of its formula") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const double distance = std::fabs(to_millimeters(mm(move.distance_mm)).count());
    const double v = std::fmin(move.speed, std::sqrt(distance * move.acceleration));
    RC_PRE(v > 0.0);
    RC_ASSERT(lasts(move.profile().duration(), distance / v + v / move.acceleration));
  }));
}

TEST_CASE("A faster or a stronger machine is never slower") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const Duration duration = move.profile().duration();
    // A nanosecond for rounding up.
    RC_ASSERT(profile(move.distance_mm, move.speed * 2, move.acceleration).duration() <= duration + 1ns);
    RC_ASSERT(profile(move.distance_mm, move.speed, move.acceleration * 2).duration() <= duration + 1ns);
  }));
}

TEST_CASE("A stop while cruising takes a ramp's time and distance") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), 2s);
  CHECK(stop.displacement == mm(18 + 2));
  CHECK(lasts(stop.duration, 2.4));
  const EarlyStop down = stopped_at(profile(-40, 10, 25), 2s);
  CHECK(down.displacement == mm(-20));
  CHECK(down.duration == stop.duration);
}

TEST_CASE("A stop while speeding up takes as long as it has sped up") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), 200ms);
  CHECK(stop.displacement == mm(1));
  CHECK(lasts(stop.duration, 0.4));
}

TEST_CASE("A stop while slowing down changes nothing") {
  const MotionProfile p = profile(40, 10, 25);
  for (const Duration t : {Duration{4s}, Duration{4200ms}, p.duration(), Duration{9s}}) {
    const EarlyStop stop = stopped_at(p, t);
    // The braking distance is computed in doubles and rounded to the nearest nanometre.
    CHECK(std::llabs((stop.displacement - mm(40)).count()) <= 1);
    CHECK(lasts(stop.duration, 4.4));
  }
}

TEST_CASE("A stop before the start stays at the start") {
  const EarlyStop stop = stopped_at(profile(40, 10, 25), -1s);
  CHECK(stop.displacement == Nanometers{0});
  CHECK(stop.duration == Duration{0});
}

TEST_CASE("A stop ends between where the plate is and where it was going") {
  CHECK(rc::check([] {
    const DrawnProfile move = draw_profile();
    const MotionProfile p = move.profile();
    const Duration t = draw_time(p);
    const EarlyStop stop = stopped_at(p, t);
    const double sign = move.distance_mm < 0 ? -1.0 : 1.0;
    const auto forward = [sign](Nanometers distance) { return sign * static_cast<double>(distance.count()); };
    // Roundings to whole nanometres.
    RC_ASSERT(forward(stop.displacement) >= forward(p.displacement(t)) - 1.0);
    RC_ASSERT(forward(stop.displacement) <= std::fabs(move.distance_mm) * 1e6 + 1.0);
    RC_ASSERT(stop.duration >= t);
    RC_ASSERT(stop.duration <= p.duration() + 1ns);
    // Braking from v takes the time v / a, and half of v times that as distance.
    const double braking_s = std::chrono::duration<double>(stop.duration - t).count();
    const double braking_nm = move.acceleration * braking_s * braking_s / 2 * 1e6;
    // A nanosecond at 50 mm/s is 0.05 nm; the roundings of both positions.
    RC_ASSERT(std::fabs(forward(stop.displacement - p.displacement(t)) - braking_nm) <= 1.5);
  }));
}
