#include "hw/motion_curve.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

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
