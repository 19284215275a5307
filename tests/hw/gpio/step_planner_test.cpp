#include "hw/gpio/step_planner.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

std::vector<Duration> times(StepPlanner& plan) {
  std::vector<Duration> all;
  for (; !plan.finished(); plan.advance())
    all.push_back(plan.next());
  return all;
}

MotionLimits draw_limits() {
  MotionLimits limits{draw_real(10, 20'000), draw_real(100, 400'000)};
  if (draw(0, 2) != 0) limits.jerk = draw_real(1'000, 20'000'000);
  return limits;
}

// Planned step times are rounded to whole nanoseconds.
constexpr double kRounding_s = 1e-9;

// True if the speeds between neighbouring steps, and the accelerations between those, are within the limits.
bool within_limits(const std::vector<Duration>& at, const MotionLimits& limits) {
  double last_speed = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const double interval = in_seconds(at[i] - at[i - 1]);
    if (interval < 1 / limits.speed - kRounding_s) return false;
    const double speed = 1 / interval;
    // The mean speed of an interval is the speed at some moment within it, and two such moments are at most
    // two intervals apart. A rounding by 1 ns changes a speed by its square times 1 ns.
    if (i > 1) {
      const double apart = in_seconds(at[i] - at[i - 2]);
      const double noise = 2 * kRounding_s * std::max(speed * speed, last_speed * last_speed);
      if (std::fabs(speed - last_speed) > limits.acceleration * apart + noise) return false;
    }
    last_speed = speed;
  }
  return true;
}

}  // namespace

TEST_CASE("Steps on a trapezoid have the times of a direct calculation") {
  // At 100 steps/s^2 the middle of step k is passed after sqrt((2k-1)/100) s; full speed after 0.5 s.
  StepPlanner plan(100, {50, 100});
  const std::vector<Duration> at = times(plan);
  REQUIRE(at.size() == 100);
  CHECK(at[0] == 100ms);
  CHECK(at[1] == Duration{173'205'081});
  CHECK(at[4] == 300ms);
  CHECK(at[50] - at[49] == 20ms);
  CHECK(plan.duration() == 2500ms);
  CHECK(at[99] == 2400ms);
}

TEST_CASE("A move of 0 steps is finished and takes no time") {
  const StepPlanner plan(0, {50, 100});
  CHECK(plan.finished());
  CHECK(plan.duration() == Duration{0});
  CHECK(StepPlanner{}.finished());
}

TEST_CASE("A move makes each of its steps once, in order, with symmetric times") {
  CHECK(rc::check([] {
    const std::int64_t steps = draw(1, 3'000);
    const MotionLimits limits = draw_limits();
    StepPlanner plan(steps, limits);
    const Duration whole = plan.duration();
    const std::vector<Duration> at = times(plan);
    RC_ASSERT(std::ssize(at) == steps);
    RC_ASSERT(at.front() > Duration{0});
    RC_ASSERT(at.back() < whole);
    for (std::size_t i = 1; i < at.size(); ++i)
      RC_ASSERT(at[i] > at[i - 1]);
    // Three roundings to 1 ns, plus that of the doubles: a ramp's end is known to 1e-16 of the distance,
    // which the slow first and last steps (speed grows with the root of the distance) turn into time.
    for (std::size_t i = 0; i < at.size(); ++i)
      RC_ASSERT(std::chrono::abs(at[i] + at[at.size() - 1 - i] - whole) <= 3ns);
  }));
}

TEST_CASE("Steps stay within the limits of speed and acceleration") {
  CHECK(rc::check([] {
    const MotionLimits limits = draw_limits();
    StepPlanner plan(draw(1, 3'000), limits);
    RC_ASSERT(within_limits(times(plan), limits));
  }));
}

TEST_CASE("The number of steps due by a time equals the number of steps planned before it") {
  CHECK(rc::check([] {
    StepPlanner plan(draw(1, 500), draw_limits());
    const StepPlanner fresh = plan;
    const std::vector<Duration> at = times(plan);
    const Duration t{draw(0, plan.duration().count())};
    const auto before = std::upper_bound(at.begin(), at.end(), t) - at.begin();
    // One more or less if a step falls on this very nanosecond.
    if (std::none_of(at.begin(), at.end(), [t](Duration s) { return std::chrono::abs(s - t) <= 1ns; })) {
      RC_ASSERT(fresh.due_by(t) == before);
    }
  }));
}

TEST_CASE("A stop makes fewer and later steps, within the limits") {
  CHECK(rc::check([] {
    const std::int64_t steps = draw(1, 3'000);
    const MotionLimits limits = draw_limits();
    StepPlanner whole(steps, limits), plan(steps, limits);
    const std::vector<Duration> unstopped = times(whole);
    const Duration stop{draw(0, plan.duration().count())};
    std::vector<Duration> at;
    for (; !plan.finished() && plan.next() <= stop; plan.advance())
      at.push_back(plan.next());
    plan.stop_at(stop);
    for (; !plan.finished(); plan.advance())
      at.push_back(plan.next());
    RC_ASSERT(std::ssize(at) <= steps);
    RC_ASSERT(std::ssize(at) == plan.done());
    for (std::size_t i = 0; i < at.size(); ++i)
      RC_ASSERT(at[i] >= unstopped[i] - 1ns);
    RC_ASSERT(within_limits(at, limits));
    RC_ASSERT(plan.duration() <= whole.duration() + 1ns);
  }));
}

TEST_CASE("A stop while cruising takes the braking distance") {
  StepPlanner plan(1'000'000, {4'000, 20'000});  // v^2 / 2a = 400 steps
  while (plan.next() < 10s)
    plan.advance();
  const std::int64_t before = plan.done();
  plan.stop_at(10s);
  CHECK(plan.total() == before + 400);
}

TEST_CASE("A stop before the first step makes none") {
  StepPlanner plan(100, {50, 100});
  plan.stop_at(0s);
  CHECK(plan.finished());
}
