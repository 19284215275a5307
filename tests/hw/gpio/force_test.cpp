// Tests of an axis with a force line: resistance on the way down, and the force of a lift.

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/random_shapes.hpp"

namespace {

using testing::draw;

// Returns an axis with a force line, whose pull-in speed is 2.5 mm/s, 2,000 steps/s.
GpioAxisConfig force_config(GpioAxisConfig config = testing::screw_config()) {
  config.force = ForceConfig{.input = {{"gpiochip0", "12", false}}, .contact_from = mm(2)};
  return config;
}

constexpr Duration kForceDebounce = 5ms;
// The debounce time, the input thread's latency and a step that is just being made.
constexpr Duration kForceLatency = kForceDebounce + 100us;
constexpr double kPullInMmS = 2.5, kForceStepsPerMm = 800;

// Sets the force at a time from now.
std::unique_ptr<Timer> force_after(Plant& plant, Duration time, bool active = true) {
  return plant.clock.call_after(time, [&plant, active] { plant.press(AxisInput::Force, active); });
}

// Returns the number of steps after `time`.
std::int64_t steps_after(const Plant& plant, TimePoint time) {
  return std::ranges::count_if(plant.pulses, [time](TimePoint at) { return at > time; });
}

}  // namespace

TEST_CASE("A plate that meets resistance on its way down stops within a step, at a known height") {
  HomedPlant plant(force_config());
  CHECK(plant.move_to(50) == MoveResult::Reached);
  const TimePoint pressed = plant.clock.now() + 1s;
  const auto press = force_after(plant, 1s);
  CHECK(plant.move_to(10, 2) == MoveResult::Resistance);
  CHECK(steps_after(plant, pressed + kForceLatency) == 0);
  CHECK(plant.events.empty());  // the result says so
  REQUIRE(plant.axis->height());
  CHECK(*plant.axis->height() > mm(47));
  CHECK(in_mm(*plant.axis->height()) * kForceStepsPerMm == Approx(testing::plate_above_switch(plant)));
  CHECK(plant.axis->force() == true);

  // The plate can go up at once, and down again when the force is gone.
  CHECK(plant.move_to(52) == MoveResult::Reached);
  plant.press(AxisInput::Force, false);
  plant.run_for(10ms);
  CHECK(plant.move_to(10) == MoveResult::Reached);
  CHECK(in_mm(*plant.axis->height()) * kForceStepsPerMm == Approx(testing::plate_above_switch(plant)));
}

TEST_CASE("Resistance at any instant of any move down stops it without a lost step") {
  CHECK(rc::check([] {
    const bool backlash = draw(0, 1) == 1, jerk = draw(0, 1) == 1;
    GpioAxisConfig config = force_config();
    if (backlash) config.backlash = Nanometers{20'000};
    if (jerk) config.jerk_mm_s3 = 500;
    Plant plant(config);
    if (backlash) plant.slack = 16;
    plant.build_homed();
    plant.pull_in =
        kPullInMmS * kForceStepsPerMm * 1.01;  // the motor loses steps when it stops dead from above
    RC_ASSERT(plant.move_to(40) == MoveResult::Reached);
    const double speed = static_cast<double>(draw(2, 100)) / 10;
    const Duration at{draw(0, 10'000'000'000)};
    const TimePoint pressed = plant.clock.now() + at;
    const auto press = force_after(plant, at);
    const auto result = plant.move_to(20, speed);
    if (plant.clock.now() > pressed + 1s) RC_ASSERT(result == MoveResult::Resistance);
    if (result == MoveResult::Resistance) {
      // A faster motor slows down to its pull-in speed first. With a limit of the jerk its acceleration has
      // to be turned round before.
      const double fast =
          std::max(0.0, speed * speed - kPullInMmS * kPullInMmS) / (2 * config.acceleration.count());
      const double late = jerk ? 2 * speed * config.acceleration.count() / *config.jerk_mm_s3 : 0;
      const std::int64_t steps = steps_after(plant, pressed + kForceLatency);
      RC_ASSERT(steps <= (speed <= kPullInMmS ? 0 : std::llround((fast + late) * kForceStepsPerMm) + 1));
    }
    RC_ASSERT(plant.axis->height().has_value());
    const double off =
        in_mm(*plant.axis->height()) * kForceStepsPerMm - static_cast<double>(plate_above_switch(plant));
    RC_ASSERT(std::fabs(off) < 0.01);
  }));
}

TEST_CASE("Near the height at which the part meets the film, force is normal") {
  HomedPlant plant(force_config());
  CHECK(plant.move_to(20) == MoveResult::Reached);
  plant.axis->expect_contact_at(mm(12));
  // The force comes 1.9 mm above the film.
  const auto press = force_after(plant, plant.axis->move_duration(mm(-6.1), MillimetersPerSecond{2}) + 100ms);
  CHECK(plant.move_to(12, 2) == MoveResult::Reached);
  CHECK(plant.axis->force() == true);
  CHECK(plant.move_to(13, 2) == MoveResult::Reached);
  CHECK(plant.move_to(12.5, 2) == MoveResult::Reached);  // begins within the zone
  CHECK(plant.move_to(15, 2) == MoveResult::Reached);
  // A force that is still there above the zone is resistance before the first millimetre.
  CHECK(plant.move_to(12, 2) == MoveResult::Resistance);
  CHECK(in_mm(*plant.axis->height()) == Approx(15).margin(0.01));
  // The bare plate meets the film at 0.
  plant.axis->expect_contact_at(mm(0));
  CHECK(plant.move_to(2.5, 2) == MoveResult::Resistance);
}

TEST_CASE("Force does not stop a move up, and a bounce shorter than the debounce time stops nothing") {
  HomedPlant plant(force_config());
  std::vector<std::pair<bool, double>> changes;
  plant.axis->on_force([&changes](const ForceChange& change) {
    changes.emplace_back(change.active, in_mm(change.height.value()));
  });
  const auto press = force_after(plant, 1s), release = force_after(plant, 2s, false);
  CHECK(plant.move_to(20, 2) == MoveResult::Reached);
  REQUIRE(changes.size() == 2);
  CHECK(changes[0].first);
  CHECK_FALSE(changes[1].first);
  CHECK(changes[0].second == Approx(2 - 0.04).margin(0.01));  // 1 s, less half the ramp of 40 ms
  CHECK(changes[1].second - changes[0].second == Approx(2).margin(0.01));

  std::vector<std::unique_ptr<Timer>> bounces;
  for (int i = 0; i < 300; ++i)
    bounces.push_back(force_after(plant, 1s + i * 4ms, i % 2 == 0));
  CHECK(plant.move_to(10, 2) == MoveResult::Reached);
  CHECK(changes.size() == 2);
}

TEST_CASE(
    "Homing downwards takes force near the switch as the resin's, and force further away as resistance") {
  const auto homed = [](Duration pressed) {
    Plant plant(force_config());
    plant.motor = 16'000;  // 20 mm above the switch: 4.1 s at 5 mm/s
    plant.build();
    const auto press = force_after(plant, pressed);
    const auto home = plant.home();
    return std::pair(home, static_cast<double>(testing::plate_above_switch(plant)) / kForceStepsPerMm);
  };
  const auto [far_away, height] = homed(1s);
  CHECK(far_away == HomingResult::Resistance);
  CHECK(height == Approx(20 - 4.75 - 2).margin(0.3));  // stops 2 mm later, and brakes
  CHECK(homed(0s).first == HomingResult::Resistance);
  CHECK(homed(0s).second == Approx(20 - 2).margin(0.3));

  Plant plant(force_config());
  plant.motor = 16'000;
  plant.build();
  const auto press = force_after(plant, 3900ms), release = force_after(plant, 4500ms, false);
  CHECK(plant.home() == HomingResult::Homed);
}

TEST_CASE("A force that is there before homing begins keeps the plate where it is") {
  BuiltPlant plant(force_config());
  plant.press(AxisInput::Force, true);
  plant.run_for(10ms);
  CHECK(plant.home() == HomingResult::Resistance);
  CHECK(plant.pulses.size() <= 2);
  CHECK_FALSE(plant.axis->height());
}

TEST_CASE("Homing upwards backs off from the switch at the top whatever the force is") {
  GpioAxisConfig config = force_config();
  config.homes_upwards = true;
  config.switch_height = config.travel;
  Plant plant(config);
  plant.limit.at = 80'000;
  plant.motor = 70'000;
  plant.build();
  plant.press(AxisInput::Force, true);
  plant.run_for(10ms);
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plant.move_to(50) == MoveResult::Resistance);
}

TEST_CASE("A move by hand from an unknown height stops at once when the plate meets resistance") {
  BuiltPlant plant(force_config());
  const TimePoint pressed = plant.clock.now() + 500ms;
  const auto press = force_after(plant, 500ms);
  CHECK(plant.nudge(-2) == MoveResult::Resistance);
  CHECK(steps_after(plant, pressed + kForceLatency) == 0);
  CHECK(plant.nudge(2) == MoveResult::Reached);  // up
}

TEST_CASE("Resistance is not waited for by a stop, and a stop by resistance can be aborted") {
  HomedPlant plant(force_config());
  CHECK(plant.move_to(50) == MoveResult::Reached);
  std::optional<MoveResult> result;
  plant.axis->move_to(mm(10), MillimetersPerSecond{10}, [&](MoveResult r) { result = r; });
  plant.run_for(2s);
  plant.axis->stop();
  plant.press(AxisInput::Force, true);
  plant.run([&] { return result.has_value(); });
  CHECK(result == MoveResult::Resistance);
  plant.press(AxisInput::Force, false);
  plant.run_for(10ms);
  plant.axis->move_to(mm(10), MillimetersPerSecond{10}, [&](MoveResult) { FAIL("aborted"); });
  plant.run_for(1s);
  plant.press(AxisInput::Force, true);
  plant.run_for(7ms);
  plant.axis->abort();
  plant.run_for(1s);
  CHECK_FALSE(plant.axis->moving());
  CHECK_FALSE(plant.axis->height());
}

TEST_CASE("A force line that cannot be read ends the motion as a fault") {
  HomedPlant plant(force_config());
  CHECK(plant.move_to(50) == MoveResult::Reached);
  const auto breaks = plant.clock.call_after(
      1s, [&plant] { plant.lines[static_cast<std::size_t>(AxisInput::Force)]->unreadable = true; });
  CHECK(plant.move_to(10) == MoveResult::Fault);
  REQUIRE(plant.events.size() == 1);
  CHECK(plant.events[0].what == "the force line cannot be read (line 12 of gpiochip0)");
}

TEST_CASE("A force that chatters while the event loop is busy costs only its record") {
  HomedPlant plant(force_config());
  CHECK(plant.move_to(20) == MoveResult::Reached);
  std::vector<std::unique_ptr<Timer>> chatter;
  for (int i = 0; i < 1000; ++i)
    chatter.push_back(force_after(plant, i * 6ms, i % 2 == 0));
  plant.run_threads_for(7s);
  CHECK_FALSE(plant.axis->lost());
  CHECK(plant.move_to(30) == MoveResult::Reached);
}
