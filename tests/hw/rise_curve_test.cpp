#include "hw/rise_curve.hpp"

#include "hw/motion_curve.hpp"
#include "tests/catch.hpp"
#include "tests/hw/rises.hpp"

namespace {

constexpr MillimetersPerSecond kTopSpeed{2};
constexpr MillimetersPerSecondSquared kAcceleration{25};
// The midpoint rule with 400 slices a piece; a nanometre of rounding of each height.
constexpr double kIntegration = 2e-4;

RisePlan plan_of(std::initializer_list<std::pair<double, double>> heights_and_speeds) {
  RisePlan plan;
  for (const auto& [height, speed] : heights_and_speeds)
    plan.points.push_back(rise_point(height, speed));
  return plan;
}

bool is_followed(std::initializer_list<std::pair<double, double>> heights_and_speeds) {
  return can_follow(plan_of(heights_and_speeds), kTopSpeed, kAcceleration);
}

}  // namespace

TEST_CASE("A plan can be followed only from rest to rest, rising, within speed and acceleration") {
  CHECK(is_followed({{1, 0}, {1.08, 2}, {3, 2}, {3.08, 0}}));
  CHECK_FALSE(is_followed({}));
  CHECK_FALSE(is_followed({{1, 0}}));
  CHECK_FALSE(is_followed({{1, 0}, {2, 0}}));  // would take for ever
  CHECK_FALSE(is_followed({{1, 0}, {2, 0}, {3, 0}}));
  CHECK_FALSE(is_followed({{1, 0.1}, {2, 1}, {3, 0}}));
  CHECK_FALSE(is_followed({{1, 0}, {2, 1}, {3, 0.1}}));
  CHECK_FALSE(is_followed({{1, 0}, {2, 1}, {2, 1}, {3, 0}}));
  CHECK_FALSE(is_followed({{3, 0}, {2, 1}, {1, 0}}));
  CHECK_FALSE(is_followed({{1, 0}, {2, 2.01}, {3, 0}}));
  CHECK_FALSE(is_followed({{1, 0}, {2, -1}, {3, 0}}));
  CHECK_FALSE(is_followed({{1, 0}, {1.079, 2}, {3, 0}}));  // 25.3 mm/s2 up
  CHECK_FALSE(is_followed({{1, 0}, {2, 2}, {2.079, 0}}));  // and down
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(is_followed({{1, 0}, {2, nan}, {3, 0}}));
  CHECK_FALSE(is_followed({{1, nan}, {2, 1}, {3, 0}}));
}

TEST_CASE("A rise passes each height at the time that a numerical integration gives") {
  CHECK(rc::check([] {
    for (int plans = 0; plans < 20; ++plans) {
      const RisePlan plan = draw_rise(Nanometers{draw(0, 50'000'000)});
      RC_ASSERT(can_follow(plan, kTopSpeed, kAcceleration));
      const RiseCurve curve(plan, 800, 0);
      const double low = in_mm(plan.points.front().height), high = in_mm(plan.points.back().height);
      for (int i = 0; i < 5; ++i) {
        const double height = draw_real(low, high), seconds = rise_time(plan, height);
        RC_ASSERT(std::fabs(curve.time_at(height * 800) - seconds) <= kIntegration * curve.duration_s());
        RC_ASSERT(std::fabs(curve.at(curve.time_at(height * 800)).position - height * 800) <= 1e-6);
      }
      RC_ASSERT(std::fabs(curve.duration_s() - rise_time(plan, high)) <= kIntegration * curve.duration_s());
    }
  }));
}

TEST_CASE("A rise is at rest before its start and after its end") {
  const RiseCurve curve(plan_of({{1, 0}, {1.08, 2}, {3, 2}, {3.08, 0}}), 1, 1);
  CHECK(curve.duration_s() == Approx(0.08 + 0.96 + 0.08));
  CHECK(curve.at(-1).position == 0);
  CHECK(curve.at(-1).speed == 0);
  CHECK(curve.at(9).position == Approx(2.08));
  CHECK(curve.at(9).speed == 0);
  CHECK(curve.at(0.56).position == Approx(1.04));
  CHECK(curve.at(0.56).speed == Approx(2));
  CHECK(curve.time_at(-1) == 0);
  CHECK(curve.time_at(9) == curve.duration_s());
}

TEST_CASE("A rise that is stopped anywhere keeps its past, and slows down by the axis' acceleration") {
  CHECK(rc::check([] {
    for (int plans = 0; plans < 20; ++plans) {
      const RisePlan plan = draw_rise(Nanometers{0});
      const RiseCurve rise(plan, 1, 0);
      MotionLimits limits{kTopSpeed.count(), kAcceleration.count()};
      if (draw(0, 1) != 0) limits.jerk = 5'000;
      MotionCurve curve(rise, limits);
      const double stop = draw_real(-0.1, rise.duration_s() + 0.1);
      curve.stop_at(stop);
      curve.stop_at(stop + 0.001);  // changes nothing
      const double before = draw_real(0, rise.duration_s());
      if (before < stop) {
        const double there = rise.at(before).position;
        RC_ASSERT(curve.position_at(before) == there);
        RC_ASSERT(curve.speed_at(before) == rise.at(before).speed);
        RC_ASSERT(std::fabs(curve.time_at(there) - rise.time_at(there)) <= 1e-9);
      }
      const RiseCurve::State then = rise.at(stop);
      const double way = curve.distance() - then.position;
      const double top = then.speed + (std::isfinite(limits.jerk) ? 25.0 * 25 / 5'000 / 2 : 0);
      const double jerk_way = std::isfinite(limits.jerk) ? top * (25.0 / 5'000) * 2 : 0;
      RC_ASSERT(way >= then.speed * then.speed / (2 * 25) - 1e-9);
      RC_ASSERT(way <= top * top / (2 * 25) + jerk_way + 1e-9);
      RC_ASSERT(curve.speed_at(curve.duration_s()) == 0);
      for (double t = std::max(stop, 0.0), last = then.speed; t < curve.duration_s(); t += 0.001) {
        const double speed = curve.speed_at(t);
        RC_ASSERT(std::fabs(speed - last) <= 25 * 0.001 + 1e-9);
        last = speed;
      }
    }
  }));
}

TEST_CASE("What is left of a rise starts at rest, is never faster, and can be followed by the same axis") {
  CHECK(rc::check([] {
    for (int plans = 0; plans < 20; ++plans) {
      const RisePlan plan = draw_rise(Nanometers{0});
      const Nanometers end = plan.points.back().height, from{draw(0, end.count())};
      const RisePlan rest = rest_of(plan, from);
      if (end - from < kLeastRise) {
        RC_ASSERT(rest.points.empty());
        continue;
      }
      RC_ASSERT(can_follow(rest, kTopSpeed, kAcceleration));
      RC_ASSERT(rest.points.front().height == from);
      RC_ASSERT(rest.points.back().height == end);
      for (int i = 0; i < 20; ++i) {
        const Nanometers height{draw(from.count(), end.count())};
        RC_ASSERT(speed_at(rest, height).count() <= speed_at(plan, height).count() + 1e-9);
      }
    }
  }));
}
