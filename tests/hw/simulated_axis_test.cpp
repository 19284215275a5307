#include "hw/simulated_axis.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <vector>

#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using Switch = SimulatedAxisConfig::Switch;

namespace {

constexpr MillimetersPerSecond kSpeed{10.0};

// An axis on its own clock, with the results of its last home() and move_to().
struct Bench {
  explicit Bench(const SimulatedAxisConfig& config = {}) : axis(clock, config) {}

  void run() {
    while (clock.run_next()) {
    }
  }
  // Lets this time pass, and runs the calls that are due.
  void pass(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over)
      clock.run_next();
  }
  void start_homing() {
    axis.home([this](HomingResult result) { homed = result; });
  }
  void start_move(Nanometers target, MillimetersPerSecond speed = kSpeed) {
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

  VirtualClock clock;
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

Nanometers mm(std::int64_t whole) {
  return Nanometers{whole * 1'000'000};
}

}  // namespace

TEST_CASE("A new axis does not know where it is") {
  Bench bench;
  CHECK_FALSE(bench.axis.height().has_value());
  CHECK_FALSE(bench.axis.height_at(TimePoint{1s}).has_value());
  CHECK_FALSE(bench.axis.moving());
}

TEST_CASE("Homing finds the switch at full speed and again at half") {
  Bench bench;
  bench.start_homing();
  CHECK(bench.axis.moving());
  CHECK_FALSE(bench.homed.has_value());
  CHECK_FALSE(bench.axis.height().has_value());
  bench.run();
  CHECK(bench.homed == HomingResult::Homed);
  CHECK(bench.axis.height() == Nanometers{0});
  CHECK_FALSE(bench.axis.moving());
  // 40 mm down at 5 mm/s, 5 mm up, 5 mm down at 2.5 mm/s.
  const SimulatedAxisConfig config;
  const auto slow = MillimetersPerSecond{config.homing_speed.count() / 2};
  CHECK(bench.clock.now().time_since_epoch() == bench.axis.move_duration(mm(40), config.homing_speed) +
                                                    bench.axis.move_duration(mm(5), config.homing_speed) +
                                                    bench.axis.move_duration(mm(5), slow));
}

TEST_CASE("Homing that starts on the switch or below it backs off first") {
  for (const std::int64_t start_mm : {0, -2}) {
    SimulatedAxisConfig config;
    config.start_height = mm(start_mm);
    Bench bench(config);
    bench.home();
    CHECK(bench.axis.height() == Nanometers{0});
    CHECK(bench.clock.now() > TimePoint{1s});
  }
}

TEST_CASE("Homing again forgets the position until it is done") {
  Bench bench;
  bench.home();
  REQUIRE(bench.move(mm(20)) == MoveResult::Reached);
  bench.start_homing();
  CHECK_FALSE(bench.axis.height().has_value());
  bench.run();
  CHECK(bench.axis.height() == Nanometers{0});
}

TEST_CASE("A switch that never closes ends homing after the full travel") {
  Bench bench(with_switch(Switch::StuckOpen));
  bench.start_homing();
  bench.run();
  CHECK(bench.homed == HomingResult::NoTrigger);
  CHECK_FALSE(bench.axis.height().has_value());
  CHECK_FALSE(bench.axis.moving());
  CHECK(bench.clock.now().time_since_epoch() >=
        bench.axis.move_duration(bench.axis.travel(), MillimetersPerSecond{5}));
  CHECK(bench.move(mm(1)) == MoveResult::NotHomed);
}

TEST_CASE("A switch that stays closed ends homing after backing off") {
  Bench bench(with_switch(Switch::StuckClosed));
  bench.start_homing();
  bench.run();
  CHECK(bench.homed == HomingResult::StillClosed);
  CHECK_FALSE(bench.axis.height().has_value());
  CHECK_FALSE(bench.axis.moving());
  CHECK(bench.clock.now().time_since_epoch() == bench.axis.move_duration(mm(5), MillimetersPerSecond{5}));
}

TEST_CASE("A move before homing is refused from the event loop and moves nothing") {
  Bench bench;
  bench.start_move(mm(1));
  CHECK_FALSE(bench.moved.has_value());
  CHECK_FALSE(bench.axis.moving());
  bench.run();
  CHECK(bench.moved == MoveResult::NotHomed);
  CHECK(bench.clock.now() == TimePoint{});
}

TEST_CASE("A nudge starts wherever the plate is, ends at the switch, and forgets the position") {
  SimulatedAxisConfig config;
  config.start_height = mm(3);
  Bench bench(config);
  const auto nudge = [&bench](std::int64_t distance_mm) {
    bench.moved.reset();
    bench.axis.nudge(mm(distance_mm), MillimetersPerSecond{1},
                     [&bench](MoveResult result) { bench.moved = result; });
    bench.run();
    return bench.moved.value();
  };
  CHECK(nudge(-2) == MoveResult::Reached);
  CHECK(bench.clock.now() > TimePoint{2s});
  CHECK_FALSE(bench.axis.height());
  CHECK(nudge(-2) == MoveResult::AtSwitch);
  CHECK(bench.axis.inputs()[0].active == true);
  const TimePoint before = bench.clock.now();
  CHECK(nudge(-1) == MoveResult::AtSwitch);
  CHECK(bench.clock.now() == before);
  CHECK(nudge(1) == MoveResult::Reached);
  CHECK(bench.axis.inputs()[0].active == false);
  CHECK(bench.move(mm(1)) == MoveResult::NotHomed);
}

TEST_CASE("A nudge that is stopped slows down, and says so") {
  Bench bench;
  bench.axis.nudge(mm(2), MillimetersPerSecond{1}, [&bench](MoveResult result) { bench.moved = result; });
  bench.pass(500ms);
  bench.axis.stop();
  bench.run();
  CHECK(bench.moved == MoveResult::Stopped);
}

TEST_CASE("Homing reports how far the switch has shifted, but only if the position was known before") {
  Bench bench;
  bench.home();
  CHECK_FALSE(bench.axis.homing_shift());
  REQUIRE(bench.move(mm(20)) == MoveResult::Reached);
  bench.home();
  CHECK(bench.axis.homing_shift() == Nanometers{0});
  REQUIRE(bench.axis.release());
  bench.home();
  CHECK_FALSE(bench.axis.homing_shift());
}

TEST_CASE("A move beyond the soft limits is refused and moves nothing") {
  Bench bench;
  bench.home();
  const TimePoint before = bench.clock.now();
  for (const Nanometers target : {Nanometers{-1}, bench.axis.travel() + Nanometers{1}, mm(1'000'000)}) {
    CHECK(bench.move(target) == MoveResult::OutsideTravel);
    CHECK(bench.axis.height() == Nanometers{0});
  }
  CHECK(bench.clock.now() == before);
  CHECK(bench.move(bench.axis.travel()) == MoveResult::Reached);
  CHECK(bench.axis.height() == mm(160));
  CHECK(bench.move(Nanometers{0}) == MoveResult::Reached);
}

TEST_CASE("A move arrives after its duration") {
  Bench bench;
  bench.home();
  const TimePoint start = bench.clock.now();
  bench.start_move(mm(40));
  CHECK(bench.axis.moving());
  bench.run();
  CHECK(bench.moved == MoveResult::Reached);
  CHECK_FALSE(bench.axis.moving());
  CHECK(bench.axis.height() == mm(40));
  CHECK(bench.clock.now() - start == bench.axis.move_duration(mm(40), kSpeed));
  // 0.4 s for both ramps over 4 mm together, 36 mm at 10 mm/s; rounded up to a nanosecond.
  CHECK(bench.clock.now() - start >= 4400ms);
  CHECK(bench.clock.now() - start <= 4400ms + 1ns);
}

TEST_CASE("A move to where the plate is arrives at once but from the event loop") {
  Bench bench;
  bench.home();
  bench.start_move(Nanometers{0});
  CHECK_FALSE(bench.moved.has_value());
  bench.run();
  CHECK(bench.moved == MoveResult::Reached);
}

TEST_CASE("Positions are the whole steps nearest to their targets") {
  Bench bench;
  bench.home();
  CHECK(bench.move(Nanometers{1'000'600}) == MoveResult::Reached);
  CHECK(bench.axis.height() == Nanometers{1'000'000});
  CHECK(bench.move(Nanometers{1'000'650}) == MoveResult::Reached);
  CHECK(bench.axis.height() == Nanometers{1'001'250});
  CHECK(rc::check([&bench] {
    const Nanometers target{testing::draw(0, 160'000'000)};
    RC_ASSERT(bench.move(target) == MoveResult::Reached);
    const Nanometers height = bench.axis.height().value();
    RC_ASSERT(on_a_whole_step(height));
    RC_ASSERT(std::llabs((height - target).count()) <= 625);  // half a step of 1250 nm
  }));
}

TEST_CASE("Thousands of layers do not drift when a step is not a whole number of nanometres") {
  SimulatedAxisConfig config;
  config.microsteps_per_mm = 3200 / 3.0;  // 937.5 nm
  Bench bench(config);
  bench.home();
  for (int layer = 1; layer <= 2000; ++layer)
    REQUIRE(bench.move(Nanometers{layer * 10'000}) == MoveResult::Reached);
  // Half a step and a nanometre's rounding.
  CHECK(std::llabs((bench.axis.height().value() - mm(20)).count()) <= 469);
}

TEST_CASE("A move can be followed while it runs") {
  Bench bench;
  bench.home();
  const TimePoint start = bench.clock.now();
  bench.start_move(mm(40));
  CHECK(bench.axis.height() == Nanometers{0});
  CHECK(bench.axis.height_at(start + 400ms) == mm(2));
  CHECK(bench.axis.height_at(start + 2200ms) == mm(20));
  CHECK(bench.axis.height_at(start + 1h) == mm(40));
  CHECK(bench.axis.height_at(start - 1h) == Nanometers{0});
  bench.pass(2200ms);
  CHECK(bench.axis.height() == mm(20));
  Nanometers last{0};
  for (Duration t{0}; t < 5s; t += 7ms) {
    const Nanometers height = bench.axis.height_at(start + t).value();
    CHECK(height >= last);
    CHECK(on_a_whole_step(height));
    last = height;
  }
}

TEST_CASE("A stop leaves a known position on a whole step") {
  for (const Duration after : {Duration{0ms}, Duration{100ms}, Duration{1234567us}, Duration{4300ms}}) {
    CAPTURE(after.count());
    Bench bench;
    bench.home();
    bench.start_move(mm(40));
    bench.pass(after);
    const Nanometers at_stop = bench.axis.height().value();
    const TimePoint stop_time = bench.clock.now();
    bench.axis.stop();
    bench.run();
    CHECK(bench.moved == MoveResult::Stopped);
    CHECK_FALSE(bench.axis.moving());
    const Nanometers end = bench.axis.height().value();
    CHECK(on_a_whole_step(end));
    // The axis brakes within v^2 / 2a = 2 mm and v / a = 0.4 s; a step and a nanosecond are for rounding.
    CHECK(end + Nanometers{1250} >= at_stop);
    CHECK(end <= at_stop + mm(2) + Nanometers{1250});
    CHECK(bench.clock.now() - stop_time <= 400ms + 1ns);
    CHECK(bench.move(mm(1)) == MoveResult::Reached);
    CHECK(bench.axis.height() == mm(1));
  }
}

TEST_CASE("A stopping plate never goes beyond where it comes to rest") {
  Bench bench;
  bench.home();
  bench.start_move(mm(40));
  bench.pass(2s);
  bench.axis.stop();
  std::vector<Nanometers> heights;
  for (int i = 0; i < 39; ++i) {
    bench.pass(10ms);
    REQUIRE(bench.axis.moving());
    heights.push_back(bench.axis.height().value());
  }
  bench.run();
  CHECK(bench.axis.height() == mm(20));
  CHECK(std::ranges::max(heights).count() <= 20'000'000);
}

TEST_CASE("A second stop changes nothing") {
  Bench bench;
  bench.home();
  bench.start_move(mm(40));
  bench.pass(2s);
  const TimePoint stop_time = bench.clock.now();
  bench.axis.stop();
  bench.pass(200ms);
  bench.axis.stop();
  bench.run();
  CHECK(bench.moved == MoveResult::Stopped);
  CHECK(bench.axis.height().value().count() == 20'000'000);
  CHECK(bench.clock.now() - stop_time <= 400ms + 1ns);
}

TEST_CASE("A stop while homing aborts it and the position stays unknown") {
  for (const Duration after : {Duration{1s}, Duration{9s}, Duration{10s}}) {
    CAPTURE(after.count());
    Bench bench;
    bench.start_homing();
    bench.pass(after);
    REQUIRE(bench.axis.moving());
    bench.axis.stop();
    bench.run();
    CHECK(bench.homed == HomingResult::Stopped);
    CHECK_FALSE(bench.axis.height().has_value());
    CHECK_FALSE(bench.axis.moving());
  }
}

TEST_CASE("A stop or an abort at rest does nothing") {
  Bench bench;
  bench.home();
  REQUIRE(bench.move(mm(3)) == MoveResult::Reached);
  bench.axis.stop();
  bench.axis.abort();
  bench.run();
  CHECK(bench.axis.height() == mm(3));
  CHECK(bench.move(mm(4)) == MoveResult::Reached);
}

TEST_CASE("An abort ends all movement at once and makes the position unknown") {
  Bench bench;
  bench.home();
  bench.start_move(mm(40));
  bench.pass(2s);
  const TimePoint before = bench.clock.now();
  bench.axis.abort();
  CHECK_FALSE(bench.axis.moving());
  CHECK_FALSE(bench.axis.height().has_value());
  bench.run();
  CHECK(bench.clock.now() == before);
  CHECK(bench.move(mm(1)) == MoveResult::NotHomed);
  bench.home();
  CHECK(bench.move(mm(1)) == MoveResult::Reached);
}

TEST_CASE("After an abort the plate stays where it was, and homing starts from there") {
  Bench bench;
  bench.home();
  bench.start_move(mm(40));
  bench.pass(2200ms);  // 20 mm
  bench.axis.abort();
  const TimePoint before = bench.clock.now();
  bench.home();
  const MillimetersPerSecond fast{5}, slow{2.5};
  CHECK(bench.clock.now() - before == bench.axis.move_duration(mm(20), fast) +
                                          bench.axis.move_duration(mm(5), fast) +
                                          bench.axis.move_duration(mm(5), slow));
}

TEST_CASE("An aborted move or homing never calls back") {
  Bench moving;
  moving.home();
  moving.start_move(mm(40));
  moving.pass(2s);
  moving.axis.abort();
  moving.run();
  CHECK_FALSE(moving.moved.has_value());
  CHECK_FALSE(moving.axis.moving());
  Bench homing;
  homing.start_homing();
  homing.pass(2s);
  homing.axis.abort();
  homing.run();
  CHECK_FALSE(homing.homed.has_value());
  CHECK_FALSE(homing.axis.moving());
}

TEST_CASE("A move may be started from inside the end of another") {
  Bench bench;
  bench.home();
  std::optional<MoveResult> second;
  bench.axis.move_to(mm(1), kSpeed, [&](MoveResult) {
    CHECK_FALSE(bench.axis.moving());
    bench.axis.move_to(mm(2), kSpeed, [&second](MoveResult result) { second = result; });
  });
  bench.run();
  CHECK(second == MoveResult::Reached);
  CHECK(bench.axis.height() == mm(2));
}

TEST_CASE("The limit switch closes at the bottom, and its edges are counted") {
  Bench bench;
  const auto limit_switch = [&bench] { return bench.axis.inputs().at(0); };
  CHECK(limit_switch().active == false);
  CHECK(limit_switch().edges == 0);
  bench.home();
  CHECK(limit_switch().name == "limit switch");
  CHECK(limit_switch().active == true);
  CHECK(limit_switch().edges == 3);
  bench.start_move(mm(40));
  bench.run();
  CHECK(limit_switch().active == false);
  CHECK(limit_switch().edges == 4);
}
