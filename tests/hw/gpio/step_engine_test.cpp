// Tests of the engine alone, with a delayed thread and the test's own clock.
#include "hw/gpio/step_engine.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/test_time.hpp"
#include "tests/random_shapes.hpp"

namespace {

// The time that the thread needs to read the clock once.
constexpr Duration kLook{100};

class Line final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active && refuses_from && std::ssize(rises) >= *refuses_from) return false;
    if (active) rises.push_back(test_time);
    return true;
  }
  std::vector<TimePoint> rises;
  std::optional<std::int64_t> refuses_from;
};

// A delay of the thread: it does not run for this long from this time after the move's start on.
struct HoldUp {
  Duration at{}, lasting{};
};

struct Run {
  Run() { test_time = TimePoint{1s}; }

  // Runs a move to its end; the event loop stops it at this time after the start, if given.
  void move(const StepMove& move, const std::vector<HoldUp>& hold_ups, std::optional<Duration> stop = {}) {
    start = test_time;
    engine.start(move);
    if (stop && *stop == Duration{0}) engine.stop();
    const bool begun = engine.begin();
    for (bool running = begun; running; running = engine.running()) {
      TimePoint wake = engine.interrupted() ? test_time + kLook : std::max(test_time, engine.due());
      wake = std::min(wake, test_time + 10ms);  // the thread checks for interruptions this often
      const TimePoint asked = stop ? start + *stop : TimePoint::max();
      if (!said_stop && wake >= asked) {
        test_time = std::max(test_time, asked);
        said_stop = true;
        engine.stop();
        continue;
      }
      for (const HoldUp& hold_up : hold_ups) {
        const TimePoint from = start + hold_up.at, until = from + hold_up.lasting;
        if (wake < from || wake >= until) continue;
        if (!said_stop && asked < until) {
          test_time = std::max(test_time, asked);
          said_stop = true;
          engine.stop();
        }
        wake = until;
      }
      test_time = wake;
      engine.act();
    }
  }

  [[nodiscard]] std::ptrdiff_t made_by(TimePoint time) const {
    return std::upper_bound(step.rises.begin(), step.rises.end(), time) - step.rises.begin();
  }

  Line step, direction;
  StepEngine engine{step, direction, {}, testing::test_now};
  TimePoint start{};
  bool said_stop = false;
};

// Returns the braking distance of a motor that has `speed` and `acceleration` at the stop, computed
// independently of the code under test.
double braking_way(double speed, double acceleration, const MotionLimits& limits) {
  if (!std::isfinite(limits.jerk)) return speed * speed / (2 * limits.acceleration);
  const double fall = std::max(acceleration, 0.0) / limits.jerk;
  const double way = speed * fall + limits.jerk * fall * fall * fall / 3;
  const double top = speed + limits.jerk * fall * fall / 2;
  const double rise = limits.acceleration / limits.jerk;
  const double ramp =
      top >= limits.acceleration * rise ? top / limits.acceleration + rise : 2 * std::sqrt(top / limits.jerk);
  return way + top * ramp / 2;
}

// Returns the longest distance that a stopping move may have left after its k-th step.
double profile_way(std::int64_t steps, const MotionLimits& limits, std::int64_t k) {
  const MotionCurve curve(static_cast<double>(steps), limits);
  const double at = curve.time_at(static_cast<double>(k) - 0.5), speed = curve.speed_at(at);
  constexpr double kMoment = 1e-5;
  const double acceleration = (speed - curve.speed_at(at - kMoment)) / kMoment;
  return braking_way(speed, std::clamp(acceleration, 0.0, limits.acceleration), limits);
}

// 5 mm/s and 50 mm/s^2 at 800 steps per mm.
constexpr MotionLimits kTrapezoid{4'000, 40'000};
constexpr MotionLimits kSCurve{4'000, 40'000, 400'000};
// A ramp takes 0.1 s or 0.2 s; the cruise lasts longer than 4 s.
constexpr std::int64_t kWay = 18'000;

}  // namespace

TEST_CASE("After a stop the steps end within the profile, however long and where the thread was delayed") {
  for (const MotionLimits& limits : {kTrapezoid, kSCurve}) {
    const Duration whole = StepPlanner(kWay, limits).duration();
    for (const Duration at : {20ms, 60ms, 2'000ms, 4'000ms}) {
      for (const Duration held : {0ms, 3ms, 100ms, 1'000ms, 4'000ms}) {
        for (const Duration asked : {at + held / 2, at + held + 1ms, at + held + 300ms}) {
          Run run;
          run.move({kWay, limits}, {{at, held}}, asked);
          INFO("held up for " << in_seconds(held) << " s at " << in_seconds(at) << " s of "
                              << in_seconds(whole) << ", stopped at " << in_seconds(asked) << " s");
          const auto before = run.made_by(run.start + asked);
          const auto travelled = static_cast<double>(std::ssize(run.step.rises) - before);
          // From the step that is due next; one step more, since the distance is rounded to whole steps.
          CHECK(travelled <= profile_way(kWay, limits, before + 1) + 2);
          CHECK(run.engine.last_end() == StepEnd::Stopped);
          CHECK(run.engine.position() == std::ssize(run.step.rises));
        }
      }
    }
  }
}

TEST_CASE("A stop while a delayed motor is at rest makes no further step") {
  for (const Duration held : {100ms, 1'000ms, 4'000ms}) {
    Run run;
    run.move({kWay, kTrapezoid}, {{1s, held}}, 1s + held / 2);
    CHECK(run.step.rises.back() <= run.start + 1s);
    CHECK(run.engine.last_end() == StepEnd::Stopped);
  }
}

TEST_CASE("However the thread is delayed, a stop ends a move within its profile") {
  CHECK(rc::check([] {
    MotionLimits limits{draw_real(50, 20'000), draw_real(500, 400'000)};
    if (draw(0, 1) != 0) limits.jerk = draw_real(5'000, 20'000'000);
    const std::int64_t steps = draw(1, 4'000);
    const Duration whole = StepPlanner(steps, limits).duration();
    const Duration held{draw(0, 1) != 0 ? draw(0, 8'000'000) : draw(0, 4'000'000'000)};
    const Duration at{draw(0, whole.count())}, stop{draw(0, (whole + held).count())};
    Run run;
    run.move({steps, limits}, {{at, held}}, stop);
    const auto before = run.made_by(run.start + stop);
    const auto made = std::ssize(run.step.rises);
    RC_ASSERT(made <= steps);
    if (before == 0) {
      RC_ASSERT(made <= 1);
      return;
    }
    const std::int64_t due = std::min<std::int64_t>(before + 1, steps);
    double most = profile_way(steps, limits, due);
    // After a rest the motor has ramped up again.
    const std::int64_t stood_at = run.made_by(run.start + at);
    if (stood_at < due) most = std::max(most, profile_way(steps - stood_at, limits, due - stood_at));
    RC_ASSERT(static_cast<double>(made - before) <= most + 2);
  }));
}

TEST_CASE("After a delay that brings it to rest the motor ramps up again") {
  for (const MotionLimits& limits : {kTrapezoid, kSCurve}) {
    for (const Duration at : {60ms, 2'000ms, 4'480ms}) {
      Run run;
      run.move({kWay, limits}, {{at, 1s}});
      CHECK(run.engine.last_end() == StepEnd::Completed);
      const auto made = run.made_by(run.start + at);
      REQUIRE(std::ssize(run.step.rises) == kWay);
      // The rest equals a new move over the remaining steps, from the time at which the thread runs again.
      StepPlanner left(kWay - made, limits);
      const TimePoint back = run.start + at + 1s;
      for (auto i = static_cast<std::size_t>(made); !left.finished(); left.advance(), ++i) {
        if (run.step.rises[i] - back - left.next() > 1us || run.step.rises[i] - back < left.next()) {
          FAIL("step " << i << " came " << (run.step.rises[i] - back).count() << " ns after the start, not "
                       << left.next().count());
        }
      }
    }
  }
}

TEST_CASE("A step that is late by less than the motor needs to stop only shifts the rest") {
  // 16 intervals of 0.25 ms after the step was due, which is up to one interval after the delay's beginning.
  for (const auto& [held, again] : {std::pair{3'900us, false}, std::pair{4'300us, true}}) {
    Run run;
    run.move({kWay, kTrapezoid}, {{1s, held}});
    const auto made = static_cast<std::size_t>(run.made_by(run.start + 1s));
    const Duration next = run.step.rises[made + 1] - run.step.rises[made];
    if (again) {
      CHECK(next > 2ms);  // the ramp's second: 5 ms by (sqrt 3 - 1)
    } else {
      CHECK(next == 250us);
    }
    CHECK(run.engine.late_steps().count == 1);
  }
}

TEST_CASE("Above its pull-in speed a motor that comes to rest has stalled, and the move may end then") {
  const auto end = [](double pull_in, bool ends, Duration at) {
    Run run;
    run.move({kWay, kTrapezoid, pull_in, ends}, {{at, 1s}});
    return std::pair{run.engine.last_end(), run.engine.stalls()};
  };
  const auto [fast, stalls] = end(2'000, true, 1s);
  CHECK(fast == StepEnd::Stalled);
  CHECK(stalls.count == 1);
  CHECK(std::chrono::abs(stalls.late - 1s) <= 250us);  // the step that was due next
  CHECK(std::abs(stalls.speed - 4'000) <= 1);
  CHECK(end(2'000, false, 1s).first == StepEnd::Completed);
  CHECK(end(2'000, false, 1s).second.count == 1);
  CHECK(end(2'000, true, 40ms).first == StepEnd::Completed);  // 1,600 steps/s
  CHECK(end(2'000, true, 40ms).second.count == 0);
  CHECK(end(2'000, true, 60ms).first == StepEnd::Stalled);  // 2,400
  CHECK(end(4'001, true, 1s).first == StepEnd::Completed);
  CHECK(end(2'000, true, 0ms).first == StepEnd::Completed);  // the motor is at rest before the first step
}

TEST_CASE("A move makes the predicted steps, whether delayed, ramping again or stopped") {
  CHECK(rc::check([] {
    const MotionLimits& limits = draw(0, 1) != 0 ? kSCurve : kTrapezoid;
    const std::int64_t steps = draw(500, 4'000), sign = draw(0, 1) != 0 ? 1 : -1;
    const Duration whole = StepPlanner(steps, limits).duration();
    const HoldUp hold_up{Duration{draw(0, whole.count() / 2)}, std::chrono::milliseconds{draw(0, 300)}};
    const TimePoint looked =
        TimePoint{1s} + hold_up.at + hold_up.lasting + Duration{draw(1, whole.count() / 2)};
    const bool stops = draw(0, 1) != 0;
    Run run;
    run.engine.start({sign * steps, limits});
    std::vector<std::pair<TimePoint, std::int64_t>> foreseen;
    for (bool running = run.engine.begin(); running; running = run.engine.running()) {
      TimePoint wake = run.engine.interrupted() ? test_time + kLook : std::max(test_time, run.engine.due());
      const TimePoint from = TimePoint{1s} + hold_up.at, until = from + hold_up.lasting;
      if (wake >= from && wake < until) wake = until;
      if (foreseen.empty() && wake > looked) {
        test_time = std::max(looked, test_time);
        if (stops) run.engine.stop();
        for (const Duration ahead : {1ms, 20ms, 50ms, 100ms, 300ms})
          foreseen.emplace_back(test_time + ahead, run.engine.position_at(test_time + ahead));
        continue;
      }
      test_time = wake;
      run.engine.act();
    }
    // A step's time is rounded to a nanosecond and may fall on this very time: one step.
    for (const auto& [time, position] : foreseen)
      RC_ASSERT(std::llabs(position - sign * run.made_by(time)) <= 1);
  }));
}

TEST_CASE("A stop ends with its move, a halt lasts until forget_halt(), inhibition until enable()") {
  Run run;
  run.move({500, kTrapezoid}, {}, 0ms);
  CHECK(run.engine.last_end() == StepEnd::Stopped);
  CHECK(run.engine.position() == 0);
  run.move({500, kTrapezoid}, {});
  CHECK(run.engine.last_end() == StepEnd::Completed);

  run.engine.halt();
  for (int moves = 0; moves < 2; ++moves) {
    run.move({500, kTrapezoid}, {});
    CHECK(run.engine.last_end() == StepEnd::Halted);
    CHECK(run.engine.position() == 500);
  }
  run.engine.forget_halt();
  run.engine.inhibit();
  run.engine.forget_halt();
  run.move({500, kTrapezoid}, {});
  CHECK(run.engine.last_end() == StepEnd::Halted);
  CHECK(run.engine.position() == 500);
  run.engine.enable();
  run.engine.forget_halt();
  run.move({500, kTrapezoid}, {});
  CHECK(run.engine.last_end() == StepEnd::Completed);
  CHECK(run.engine.position() == 1'000);
}

TEST_CASE("However a move ends, its position is its start plus the steps that the line has accepted") {
  CHECK(rc::check([] {
    Run run;
    std::int64_t position = 0;
    for (int moves = 0; moves < 5; ++moves) {
      const std::int64_t steps = draw(-400, 400);
      const auto rises = std::ssize(run.step.rises);
      run.said_stop = false;
      run.step.refuses_from = draw(0, 3) == 0 ? std::optional(rises + draw(0, 400)) : std::nullopt;
      run.move(
          {steps, kTrapezoid}, {{10ms, std::chrono::milliseconds{draw(0, 50)}}},
          draw(0, 1) != 0 ? std::optional(Duration{std::chrono::milliseconds{draw(0, 100)}}) : std::nullopt);
      position += (steps < 0 ? -1 : 1) * (std::ssize(run.step.rises) - rises);
      RC_ASSERT(!run.engine.moving());
      RC_ASSERT(run.engine.position() == position);
      RC_ASSERT(run.engine.position_at(test_time) == position);
      const std::int64_t elsewhere = draw(-100, 100);
      run.engine.set_position(elsewhere);
      RC_ASSERT(run.engine.position_at(test_time) == elsewhere);
      position = elsewhere;
      run.engine.forget_halt();
      test_time += 1ms;
    }
  }));
}
