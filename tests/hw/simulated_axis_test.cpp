#include "hw/simulated_axis.hpp"

#include "tests/catch.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/hw/rises.hpp"
#include "tests/hw/virtual_time_fixture.hpp"
#include "tests/random_shapes.hpp"

namespace {

using Switch = SimulatedAxisConfig::Switch;

constexpr MillimetersPerSecond kMoveSpeed{10.0};

// An axis on its own clock, with the results of its last home() and move_to().
struct SimulatedAxisFixture : testing::VirtualTimeFixture {
  explicit SimulatedAxisFixture(const SimulatedAxisConfig& config = {}) : axis(clock, config) {}

  void start_homing() {
    axis.home([this](HomingResult result) { homed = result; });
  }
  void start_move(Nanometers target, MillimetersPerSecond speed = kMoveSpeed) {
    moved.reset();
    axis.move_to(target, speed, [this](MoveResult result) { moved = result; });
  }
  void home() {
    start_homing();
    run();
    REQUIRE(homed == HomingResult::Homed);
  }
  MoveResult move(Nanometers target) {
    start_move(target);
    run();
    return moved.value();
  }

  SimulatedAxis axis;
  std::optional<HomingResult> homed;
  std::optional<MoveResult> moved;
};

SimulatedAxisConfig with_switch(Switch limit_switch) {
  SimulatedAxisConfig config;
  config.limit_switch = limit_switch;
  return config;
}

bool on_a_whole_step(Nanometers height) {
  return height.count() % 1250 == 0;
}

}  // namespace

TEST_CASE_METHOD(SimulatedAxisFixture, "A new axis does not know where it is") {
  CHECK_FALSE(axis.height().has_value());
  CHECK_FALSE(axis.height_at(TimePoint{1s}).has_value());
  CHECK_FALSE(axis.moving());
}

TEST_CASE_METHOD(SimulatedAxisFixture, "Homing finds the switch at full speed and again at half") {
  start_homing();
  CHECK(axis.moving());
  CHECK_FALSE(homed.has_value());
  CHECK_FALSE(axis.height().has_value());
  run();
  CHECK(homed == HomingResult::Homed);
  CHECK(axis.height() == Nanometers{0});
  CHECK_FALSE(axis.moving());
  // 40 mm down at 5 mm/s, 5 mm up, 5 mm down at 2.5 mm/s.
  const SimulatedAxisConfig config;
  const auto slow = MillimetersPerSecond{config.homing_speed.count() / 2};
  CHECK(clock.now().time_since_epoch() == axis.move_duration(mm(40), config.homing_speed) +
                                              axis.move_duration(mm(5), config.homing_speed) +
                                              axis.move_duration(mm(5), slow));
}

TEST_CASE("Homing that starts on the switch or below it backs off first") {
  for (const double start_mm : {0.0, -2.0}) {
    SimulatedAxisConfig config;
    config.start_height = mm(start_mm);
    SimulatedAxisFixture fixture(config);
    fixture.home();
    CHECK(fixture.axis.height() == Nanometers{0});
    CHECK(fixture.clock.now() > TimePoint{1s});
  }
}

TEST_CASE_METHOD(SimulatedAxisFixture, "Homing again forgets the position until it is done") {
  home();
  REQUIRE(move(mm(20)) == MoveResult::Reached);
  start_homing();
  CHECK_FALSE(axis.height().has_value());
  run();
  CHECK(axis.height() == Nanometers{0});
}

TEST_CASE(
    "A switch that never closes ends homing after the full travel, one that stays closed after backing off") {
  for (const bool closed : {false, true}) {
    CAPTURE(closed);
    SimulatedAxisFixture fixture(with_switch(closed ? Switch::StuckClosed : Switch::StuckOpen));
    fixture.start_homing();
    fixture.run();
    CHECK(fixture.homed == (closed ? HomingResult::StillClosed : HomingResult::NoTrigger));
    CHECK_FALSE(fixture.axis.height().has_value());
    CHECK_FALSE(fixture.axis.moving());
    const Duration took = fixture.clock.now().time_since_epoch(),
                   backing_off = fixture.axis.move_duration(mm(5), MillimetersPerSecond{5});
    CHECK((took == backing_off) == closed);
    CHECK((took >= fixture.axis.move_duration(fixture.axis.travel(), MillimetersPerSecond{5})) == !closed);
    CHECK(fixture.move(mm(1)) == MoveResult::NotHomed);
  }
}

TEST_CASE_METHOD(SimulatedAxisFixture,
                 "A move before homing is refused from the event loop and moves nothing") {
  start_move(mm(1));
  CHECK_FALSE(moved.has_value());
  CHECK_FALSE(axis.moving());
  run();
  CHECK(moved == MoveResult::NotHomed);
  CHECK(clock.now() == TimePoint{});
}

TEST_CASE("A nudge starts wherever the plate is, ends at the switch, and forgets the position") {
  SimulatedAxisConfig config;
  config.start_height = mm(3);
  SimulatedAxisFixture fixture(config);
  const auto nudge = [&fixture](double distance_mm) {
    fixture.moved.reset();
    fixture.axis.nudge(mm(distance_mm), MillimetersPerSecond{1},
                       [&fixture](MoveResult result) { fixture.moved = result; });
    fixture.run();
    return fixture.moved.value();
  };
  CHECK(nudge(-2) == MoveResult::Reached);
  CHECK(fixture.clock.now() > TimePoint{2s});
  CHECK_FALSE(fixture.axis.height());
  CHECK(nudge(-2) == MoveResult::AtSwitch);
  CHECK(fixture.axis.inputs()[0].active == true);
  const TimePoint before = fixture.clock.now();
  CHECK(nudge(-1) == MoveResult::AtSwitch);
  CHECK(fixture.clock.now() == before);
  CHECK(nudge(1) == MoveResult::Reached);
  CHECK(fixture.axis.inputs()[0].active == false);
  CHECK(fixture.move(mm(1)) == MoveResult::NotHomed);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A nudge that is stopped slows down, and says so") {
  axis.nudge(mm(2), MillimetersPerSecond{1}, [this](MoveResult result) { moved = result; });
  pass(500ms);
  axis.stop();
  run();
  CHECK(moved == MoveResult::Stopped);
}

TEST_CASE_METHOD(SimulatedAxisFixture,
                 "Homing reports how far the switch has shifted, but only if the position was known before") {
  home();
  CHECK_FALSE(axis.homing_shift());
  REQUIRE(move(mm(20)) == MoveResult::Reached);
  home();
  CHECK(axis.homing_shift() == Nanometers{0});
  REQUIRE(axis.release());
  home();
  CHECK_FALSE(axis.homing_shift());
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A move beyond the soft limits is refused and moves nothing") {
  home();
  const TimePoint before = clock.now();
  for (const Nanometers target : {Nanometers{-1}, axis.travel() + Nanometers{1}, mm(1'000'000)}) {
    CHECK(move(target) == MoveResult::OutsideTravel);
    CHECK(axis.height() == Nanometers{0});
  }
  CHECK(clock.now() == before);
  CHECK(move(axis.travel()) == MoveResult::Reached);
  CHECK(axis.height() == mm(160));
  CHECK(move(Nanometers{0}) == MoveResult::Reached);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A move arrives after its duration") {
  home();
  const TimePoint start = clock.now();
  start_move(mm(40));
  CHECK(axis.moving());
  run();
  CHECK(moved == MoveResult::Reached);
  CHECK_FALSE(axis.moving());
  CHECK(axis.height() == mm(40));
  CHECK(clock.now() - start == axis.move_duration(mm(40), kMoveSpeed));
  // 0.4 s for both ramps over 4 mm together, 36 mm at 10 mm/s; rounded up to a nanosecond.
  CHECK(clock.now() - start >= 4400ms);
  CHECK(clock.now() - start <= 4400ms + 1ns);
}

TEST_CASE_METHOD(SimulatedAxisFixture,
                 "A move to where the plate is arrives at once but from the event loop") {
  home();
  start_move(Nanometers{0});
  CHECK_FALSE(moved.has_value());
  run();
  CHECK(moved == MoveResult::Reached);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "Positions are the whole steps nearest to their targets") {
  home();
  CHECK(move(Nanometers{1'000'600}) == MoveResult::Reached);
  CHECK(axis.height() == Nanometers{1'000'000});
  CHECK(move(Nanometers{1'000'650}) == MoveResult::Reached);
  CHECK(axis.height() == Nanometers{1'001'250});
  CHECK(rc::check([this] {
    const Nanometers target{testing::draw(0, 160'000'000)};
    RC_ASSERT(move(target) == MoveResult::Reached);
    const Nanometers height = axis.height().value();
    RC_ASSERT(on_a_whole_step(height));
    RC_ASSERT(std::llabs((height - target).count()) <= 625);  // half a step of 1250 nm
  }));
}

TEST_CASE("Thousands of layers do not drift when a step is not a whole number of nanometres") {
  SimulatedAxisConfig config;
  config.microsteps_per_mm = 3200 / 3.0;  // 937.5 nm
  SimulatedAxisFixture fixture(config);
  fixture.home();
  for (int layer = 1; layer <= 2000; ++layer)
    REQUIRE(fixture.move(Nanometers{layer * 10'000}) == MoveResult::Reached);
  // Half a step and a nanometre's rounding.
  CHECK(std::llabs((fixture.axis.height().value() - mm(20)).count()) <= 469);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A move can be followed while it runs") {
  home();
  const TimePoint start = clock.now();
  start_move(mm(40));
  CHECK(axis.height() == Nanometers{0});
  CHECK(axis.height_at(start + 400ms) == mm(2));
  CHECK(axis.height_at(start + 2200ms) == mm(20));
  CHECK(axis.height_at(start + 1h) == mm(40));
  CHECK(axis.height_at(start - 1h) == Nanometers{0});
  pass(2200ms);
  CHECK(axis.height() == mm(20));
  Nanometers last{0};
  for (Duration t{0}; t < 5s; t += 7ms) {
    const Nanometers height = axis.height_at(start + t).value();
    CHECK(height >= last);
    CHECK(on_a_whole_step(height));
    last = height;
  }
}

TEST_CASE("A stop leaves a known position on a whole step") {
  for (const Duration after : {Duration{0ms}, Duration{100ms}, Duration{1234567us}, Duration{4300ms}}) {
    CAPTURE(after.count());
    SimulatedAxisFixture fixture;
    fixture.home();
    fixture.start_move(mm(40));
    fixture.pass(after);
    const Nanometers at_stop = fixture.axis.height().value();
    const TimePoint stop_time = fixture.clock.now();
    fixture.axis.stop();
    fixture.run();
    CHECK(fixture.moved == MoveResult::Stopped);
    CHECK_FALSE(fixture.axis.moving());
    const Nanometers end = fixture.axis.height().value();
    CHECK(on_a_whole_step(end));
    // The axis brakes within v^2 / 2a = 2 mm and v / a = 0.4 s; a step and a nanosecond are for rounding.
    CHECK(end + Nanometers{1250} >= at_stop);
    CHECK(end <= at_stop + mm(2) + Nanometers{1250});
    CHECK(fixture.clock.now() - stop_time <= 400ms + 1ns);
    CHECK(fixture.move(mm(1)) == MoveResult::Reached);
    CHECK(fixture.axis.height() == mm(1));
  }
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A stopping plate never goes beyond where it comes to rest") {
  home();
  start_move(mm(40));
  pass(2s);
  axis.stop();
  std::vector<Nanometers> heights;
  for (int i = 0; i < 39; ++i) {
    pass(10ms);
    REQUIRE(axis.moving());
    heights.push_back(axis.height().value());
  }
  run();
  CHECK(axis.height() == mm(20));
  CHECK(std::ranges::max(heights).count() <= 20'000'000);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A second stop changes nothing") {
  home();
  start_move(mm(40));
  pass(2s);
  const TimePoint stop_time = clock.now();
  axis.stop();
  pass(200ms);
  axis.stop();
  run();
  CHECK(moved == MoveResult::Stopped);
  CHECK(axis.height().value().count() == 20'000'000);
  CHECK(clock.now() - stop_time <= 400ms + 1ns);
}

TEST_CASE("A stop while homing aborts it and the position stays unknown") {
  for (const Duration after : {Duration{1s}, Duration{9s}, Duration{10s}}) {
    CAPTURE(after.count());
    SimulatedAxisFixture fixture;
    fixture.start_homing();
    fixture.pass(after);
    REQUIRE(fixture.axis.moving());
    fixture.axis.stop();
    fixture.run();
    CHECK(fixture.homed == HomingResult::Stopped);
    CHECK_FALSE(fixture.axis.height().has_value());
    CHECK_FALSE(fixture.axis.moving());
  }
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A stop or an abort at rest does nothing") {
  home();
  REQUIRE(move(mm(3)) == MoveResult::Reached);
  axis.stop();
  axis.abort();
  run();
  CHECK(axis.height() == mm(3));
  CHECK(move(mm(4)) == MoveResult::Reached);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "An abort ends all movement at once and makes the position unknown") {
  home();
  start_move(mm(40));
  pass(2s);
  const TimePoint before = clock.now();
  axis.abort();
  CHECK_FALSE(axis.moving());
  CHECK_FALSE(axis.height().has_value());
  run();
  CHECK(clock.now() == before);
  CHECK(move(mm(1)) == MoveResult::NotHomed);
  home();
  CHECK(move(mm(1)) == MoveResult::Reached);
}

TEST_CASE_METHOD(SimulatedAxisFixture,
                 "After an abort the plate stays where it was, and homing starts from there") {
  home();
  start_move(mm(40));
  pass(2200ms);  // 20 mm
  axis.abort();
  const TimePoint before = clock.now();
  home();
  const MillimetersPerSecond fast{5}, slow{2.5};
  CHECK(clock.now() - before ==
        axis.move_duration(mm(20), fast) + axis.move_duration(mm(5), fast) + axis.move_duration(mm(5), slow));
}

TEST_CASE("An aborted move or homing never calls back") {
  SimulatedAxisFixture moving;
  moving.home();
  moving.start_move(mm(40));
  moving.pass(2s);
  moving.axis.abort();
  moving.run();
  CHECK_FALSE(moving.moved.has_value());
  CHECK_FALSE(moving.axis.moving());
  SimulatedAxisFixture homing;
  homing.start_homing();
  homing.pass(2s);
  homing.axis.abort();
  homing.run();
  CHECK_FALSE(homing.homed.has_value());
  CHECK_FALSE(homing.axis.moving());
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A move may be started from inside the end of another") {
  home();
  std::optional<MoveResult> second;
  axis.move_to(mm(1), kMoveSpeed, [&](MoveResult) {
    CHECK_FALSE(axis.moving());
    axis.move_to(mm(2), kMoveSpeed, [&second](MoveResult result) { second = result; });
  });
  run();
  CHECK(second == MoveResult::Reached);
  CHECK(axis.height() == mm(2));
}

TEST_CASE_METHOD(SimulatedAxisFixture, "The limit switch closes at the bottom, and its edges are counted") {
  const auto limit_switch = [this] { return axis.inputs().at(0); };
  CHECK(limit_switch().active == false);
  CHECK(limit_switch().edges == 0);
  home();
  CHECK(limit_switch().name == "limit switch");
  CHECK(limit_switch().active == true);
  CHECK(limit_switch().edges == 3);
  start_move(mm(40));
  run();
  CHECK(limit_switch().active == false);
  CHECK(limit_switch().edges == 4);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A simulated rise follows its plan, to the microstep") {
  CHECK(rc::check([] {
    SimulatedAxisFixture fixture;
    fixture.home();
    for (int plans = 0; plans < 20; ++plans) {
      const RisePlan plan = draw_rise(fixture.axis.height().value());
      const TimePoint begun = fixture.clock.now();
      fixture.moved.reset();
      fixture.axis.rise(plan, [&](MoveResult result) { fixture.moved = result; });
      const double low = in_mm(plan.points.front().height), high = in_mm(plan.points.back().height);
      const double height = draw_real(low, high);
      const Duration after{static_cast<Duration::rep>(rise_time(plan, height) * 1e9)};
      const Nanometers there = fixture.axis.height_at(begun + after).value();
      // The integration is exact to 0.2 ms/s of a rise of at most 5 s at 2 mm/s, and a step has 1.25 um.
      RC_ASSERT(std::fabs(in_mm(there) - height) <= 0.002 + 0.00125);
      RC_ASSERT(on_a_whole_step(there));
      fixture.pass(after);
      RC_ASSERT(fixture.axis.height() == fixture.axis.height_at(fixture.clock.now()));
      const bool stops = draw(0, 1) != 0;
      if (stops) fixture.axis.stop();
      fixture.run();
      RC_ASSERT(fixture.moved == (stops ? MoveResult::Stopped : MoveResult::Reached));
      const double end = in_mm(fixture.axis.height().value());
      RC_ASSERT(end <= (stops ? height + 0.08 + 0.004 : high + 0.001));
      RC_ASSERT(end >= (stops ? height - 0.004 : high - 0.001));
    }
  }));
}

TEST_CASE_METHOD(SimulatedAxisFixture, "A simulated axis refuses the rises that a real one refuses") {
  const auto rise = [this](const RisePlan& plan) {
    moved.reset();
    const auto before = axis.height();
    axis.rise(plan, [this](MoveResult result) { moved = result; });
    run();
    CHECK(axis.height() == before);
    return moved.value();
  };
  const auto plan = [](double from, double to, double speed) {
    return RisePlan{{rise_point(from, 0), rise_point((from + to) / 2, speed), rise_point(to, 0)}};
  };
  CHECK(rise(plan(0, 1, 1)) == MoveResult::NotHomed);
  home();
  CHECK(rise({}) == MoveResult::PlanRefused);
  CHECK(rise(plan(0, 1, 2.6)) == MoveResult::PlanRefused);
  CHECK(rise(plan(0.01, 1, 1)) == MoveResult::PlanRefused);
  CHECK(rise(plan(0, 161, 1)) == MoveResult::OutsideTravel);
  CHECK(rise(plan(-0.001, 1, 1)) == MoveResult::OutsideTravel);
}

TEST_CASE(
    "An axis with its switch at the top homes upwards, and rises to the switch from an unknown position") {
  SimulatedAxisConfig config;
  config.homes_upwards = true;
  SimulatedAxisFixture fixture(config);
  CHECK(fixture.axis.homes_upwards());
  fixture.start_homing();
  fixture.run();
  CHECK(fixture.homed == HomingResult::Homed);
  CHECK(fixture.axis.height() == fixture.axis.travel());
  CHECK(fixture.move(mm(100)) == MoveResult::Reached);
  const auto raise = [&fixture](Nanometers distance) {
    std::optional<MoveResult> raised;
    fixture.axis.raise(distance, MillimetersPerSecond{5}, [&](MoveResult result) { raised = result; });
    fixture.run();
    return raised;
  };
  CHECK(raise(mm(20)) == MoveResult::Reached);
  CHECK_FALSE(fixture.axis.height());
  CHECK(raise(mm(50)) == MoveResult::AtSwitch);
  CHECK(raise(mm(1)) == MoveResult::AtSwitch);
}

TEST_CASE_METHOD(SimulatedAxisFixture, "An axis takes an assumed height as its own") {
  axis.assume_height(mm(12));
  CHECK(axis.height() == mm(12));
  CHECK(move(mm(20)) == MoveResult::Reached);
  CHECK(axis.height() == mm(20));
}
