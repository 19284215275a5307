#include "hw/gpio/gpio_axis.hpp"

#include "hw/hardware_error.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/plant_axis.hpp"
#include "tests/hw/millimeters.hpp"
#include "tests/random_shapes.hpp"

namespace {

GpioAxisConfig with_enable(GpioAxisConfig c = screw_config()) {
  c.enable = GpioLineConfig{"gpiochip0", "22", true};
  return c;
}

bool only_event_says(const Plant& plant, MachineEvent::Kind kind, const std::string& words) {
  if (plant.events.size() != 1) return false;
  UNSCOPED_INFO(plant.events[0].what);
  return plant.events[0].kind == kind && plant.events[0].what.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("An axis that has not homed has no known height and refuses moves") {
  Plant plant(screw_config());
  GpioAxis& axis = plant.build();
  CHECK_FALSE(axis.height());
  CHECK_FALSE(axis.height_at(plant.clock.now()));
  CHECK(plant.move_to(10) == MoveResult::NotHomed);
  CHECK(plant.pulses.empty());
}

TEST_CASE("Homing brings the plate to the switch's height, exact to the step") {
  Plant plant(screw_config());
  GpioAxis& axis = plant.build();
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
  CHECK(axis.height() == Nanometers{0});
  CHECK_FALSE(axis.moving());
  CHECK(plant.events.empty());
}

TEST_CASE("Homing is exact however the switch bounces and however late its edges are read") {
  CHECK(rc::check([] {
    Plant plant(screw_config());
    plant.motor = draw(-3, 5'000);
    plant.limit.hysteresis = draw(0, 400);
    plant.limit.bounces = static_cast<int>(draw(0, 6));
    plant.limit.bounce = std::chrono::microseconds{draw(50, 1'000)};
    plant.input_latency = std::chrono::microseconds{draw(0, 3'000)};
    plant.build();
    RC_ASSERT(plant.home() == HomingResult::Homed);
    RC_ASSERT(plate_above_switch(plant) == 0);
    // The bounces when the switch opens during backing off are no contact.
    RC_ASSERT(plant.move_to(2) == MoveResult::Reached);
    RC_ASSERT(plate_above_switch(plant) == 1'600);
  }));
}

TEST_CASE("Homing is exact when steps are made while the switch's level is read") {
  // Levels are read every 20 ms; at some of these speeds the switch closes during a read.
  for (int speed = 400; speed < 440; ++speed) {
    CAPTURE(speed);
    GpioAxisConfig c = screw_config();
    c.homing_speed = MillimetersPerSecond{speed / 100.0};
    Plant plant(c);
    plant.motor = 1'000;
    plant.input_latency = 3ms;  // longer than the read, so the edge's event is found after the level
    plant.build();
    plant.lines[0]->before_level = [&plant] { plant.preempt_for(2'500us); };
    REQUIRE(plant.home() == HomingResult::Homed);
    CHECK(plate_above_switch(plant) == 0);
  }
}

TEST_CASE("Homing overruns the edge only by the steps within the input thread's latency") {
  Plant plant(screw_config());
  plant.input_latency = 1ms;  // 4 steps at 4,000/s
  plant.build();
  std::int64_t lowest = 0;
  plant.loses_step = [&] {
    lowest = std::min(lowest, plate_above_switch(plant));
    return false;
  };
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(lowest >= -5);
  CHECK(lowest <= -3);
}

TEST_CASE("Homing sets the configured switch height, and moves count from there") {
  GpioAxisConfig c = screw_config();
  c.switch_height = mm(-0.5);
  Plant plant(c);
  GpioAxis& axis = plant.build_homed();
  CHECK(axis.height() == mm(-0.5));
  CHECK(plant.move_to(0) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 400);
}

TEST_CASE("Homing upwards finds the switch at the top") {
  GpioAxisConfig c = screw_config();
  c.homes_upwards = true;
  c.switch_height = mm(100.5);
  Plant plant(c);
  plant.limit.at = 60'000;
  plant.build_homed();
  CHECK(plate_above_switch(plant) == 0);
  CHECK(plant.axis->height() == mm(100.5));
  CHECK(plant.move_to(40) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == -48'400);
}

TEST_CASE("Homing from a closed switch first moves away from it") {
  Plant plant(screw_config());
  plant.motor = -20;
  plant.build();
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE("Homing ends after the whole travel if the switch never closes, after 5 mm if it stays closed") {
  for (const bool closed : {false, true}) {
    CAPTURE(closed);
    Plant plant(screw_config());
    plant.limit.stuck = closed;
    plant.build();
    CHECK(plant.home() == (closed ? HomingResult::StillClosed : HomingResult::NoTrigger));
    CHECK(plant.pulses.size() == (closed ? 5U : 100U + 5U) * 800);
    CHECK_FALSE(plant.axis->height());
  }
}

TEST_CASE("A spike on the limit switch's line does not end a pass") {
  BuiltPlant plant;
  const auto press = plant.clock.call_after(500ms, [&] { plant.press(AxisInput::LimitSwitch, true); });
  const auto release = plant.clock.call_after(502ms, [&] { plant.press(AxisInput::LimitSwitch, false); });
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE("A lost edge of the limit switch is found by its level") {
  BuiltPlant plant;
  plant.lines[0]->loses_edges = true;
  CHECK(plant.home() == HomingResult::Homed);
  // The level is read every 20 ms: 40 steps at 2,000 steps/s.
  CHECK(plate_above_switch(plant) >= -41);
  CHECK(plate_above_switch(plant) <= 0);
}

TEST_CASE("A motor that turns the wrong way is noticed by the second switch") {
  Plant plant(with_second_switch());
  plant.reversed = true;
  plant.second.at = 5'000;
  plant.build();
  CHECK(plant.home() == HomingResult::WrongSwitch);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "line 24 of gpiochip0"));
}

TEST_CASE("Homing reports how far the switch has shifted since the last homing, by the steps in between") {
  HomedPlant plant;
  CHECK_FALSE(plant.axis->homing_shift());
  REQUIRE(plant.move_to(20) == MoveResult::Reached);
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(plant.axis->homing_shift() == Nanometers{0});
  plant.limit.at = -8;  // the switch closes 10 um lower
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(plant.axis->homing_shift() == Nanometers{-10'000});
  int lost = 0;  // 10 steps on the way up
  plant.loses_step = [&lost] { return lost++ < 10; };
  REQUIRE(plant.move_to(20) == MoveResult::Reached);
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(plant.axis->homing_shift() == Nanometers{12'500});
}

TEST_CASE("Homing from an unknown position reports no shift, nor does one that does not finish") {
  HomedPlant plant;
  SECTION("the position was lost") {
    REQUIRE(plant.nudge(1) == MoveResult::Reached);
    REQUIRE(plant.home() == HomingResult::Homed);
    CHECK_FALSE(plant.axis->homing_shift());
  }
  SECTION("the homing before was stopped") {
    REQUIRE(plant.move_to(20) == MoveResult::Reached);
    plant.axis->home([](HomingResult) {});
    plant.run_for(1s);
    plant.axis->stop();
    plant.run();
    REQUIRE(plant.home() == HomingResult::Homed);
    CHECK_FALSE(plant.axis->homing_shift());
  }
  SECTION("the switch no longer closes") {
    plant.limit.stuck = false;
    REQUIRE(plant.home() == HomingResult::NoTrigger);
    CHECK_FALSE(plant.axis->homing_shift());
  }
}

TEST_CASE("A nudge moves its distance from an unknown position and leaves the position unknown") {
  for (const double way : {2.0, -2.0, 0.3}) {
    CAPTURE(way);
    for (const bool homed : {false, true}) {
      BuiltPlant plant(with_enable());
      if (homed) REQUIRE(plant.home() == HomingResult::Homed);
      if (homed) REQUIRE(plant.move_to(5) == MoveResult::Reached);
      const std::int64_t from = plant.plate();
      CHECK(plant.nudge(way) == MoveResult::Reached);
      CHECK(plant.plate() - from == std::llround(way * 800));
      CHECK_FALSE(plant.axis->height());
      CHECK_FALSE(plant.axis->moving());
      CHECK(plant.disabled_steps == 0);
      CHECK(plant.move_to(10) == MoveResult::NotHomed);
      CHECK(plant.events.empty());
    }
  }
}

TEST_CASE("A nudge ends where the switch closes, whichever way the motor turns, without a fault") {
  for (const bool reversed : {false, true}) {
    CAPTURE(reversed);
    Plant plant(screw_config());
    plant.motor = 800;  // 1 mm above the switch
    plant.reversed = reversed;
    plant.limit.bounces = 3;
    plant.limit.bounce = 500us;
    plant.build();
    CHECK(plant.nudge(reversed ? 2 : -2) == MoveResult::AtSwitch);
    CHECK(plate_above_switch(plant) <= 0);
    CHECK(plate_above_switch(plant) >= -2);
    CHECK_FALSE(plant.axis->moving());
    CHECK(plant.events.empty());
    // A nudge further towards the switch makes no step; one away from it moves.
    plant.pulses.clear();
    CHECK(plant.nudge(reversed ? 2 : -2) == (reversed ? MoveResult::Reached : MoveResult::AtSwitch));
    if (!reversed) CHECK(plant.pulses.empty());
    CHECK(plant.nudge(reversed ? -2 : 2) == (reversed ? MoveResult::AtSwitch : MoveResult::Reached));
  }
}

TEST_CASE("The plate rises further than a nudge from an unknown position, and its position stays unknown") {
  BuiltPlant plant(with_enable());
  const std::int64_t from = plant.plate();
  std::optional<MoveResult> raised;
  plant.axis->raise(Nanometers{15'000'000}, MillimetersPerSecond{2},
                    [&](MoveResult result) { raised = result; });
  plant.run();
  CHECK(raised == MoveResult::Reached);
  CHECK(plant.plate() - from == 15 * 800);
  CHECK_FALSE(plant.axis->height());
  CHECK(plant.events.empty());
}

TEST_CASE("Moves from an assumed height end where they would after homing") {
  for (const Nanometers backlash : {Nanometers{0}, Nanometers{50'000}}) {
    GpioAxisConfig config = with_enable();
    config.backlash = backlash;
    BuiltPlant plant(config);
    const std::int64_t from = plant.plate();
    plant.axis->assume_height(Nanometers{12'000'000});
    CHECK(plant.axis->height() == Nanometers{12'000'000});
    CHECK(plant.pulses.empty());
    REQUIRE(plant.move_to(20) == MoveResult::Reached);
    CHECK(plant.plate() - from == 8 * 800);
    REQUIRE(plant.move_to(12.1) == MoveResult::Reached);
    CHECK(plant.plate() - from == 80);
  }
}

TEST_CASE("A nudge also ends at a spike on the switch's line") {
  BuiltPlant plant;
  const auto press = plant.clock.call_after(500ms, [&] { plant.press(AxisInput::LimitSwitch, true); });
  const auto release = plant.clock.call_after(502ms, [&] { plant.press(AxisInput::LimitSwitch, false); });
  CHECK(plant.nudge(2) == MoveResult::AtSwitch);
  CHECK(plant.events.empty());
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE("A nudge ends at the second switch, at the emergency stop and at a stop") {
  SECTION("the second switch") {
    Plant plant(with_second_switch());
    plant.second.at = 4'800;
    plant.build();
    CHECK(plant.nudge(2) == MoveResult::Fault);
    CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "line 24 of gpiochip0"));
    CHECK(plant.plate() <= 4'850);  // detected within some milliseconds at 800 steps/s
  }
  SECTION("the emergency stop") {
    GpioAxisConfig c = screw_config();
    c.emergency_stop = GpioInputConfig{{"gpiochip0", "5", false}};
    BuiltPlant plant(c);
    const auto press = plant.clock.call_after(500ms, [&] { plant.press(AxisInput::EmergencyStop, true); });
    CHECK(plant.nudge(2) == MoveResult::Fault);
    CHECK(plant.plate() < 4'800);
  }
  SECTION("a stop") {
    BuiltPlant plant;
    const auto stop = plant.clock.call_after(500ms, [&] { plant.axis->stop(); });
    CHECK(plant.nudge(2) == MoveResult::Stopped);
    CHECK(plant.plate() < 4'800);
    CHECK_FALSE(plant.axis->height());
  }
  SECTION("an abort, after which it homes as usual") {
    BuiltPlant plant;
    plant.axis->nudge(mm(-2), MillimetersPerSecond{1}, [](MoveResult) { FAIL("it was aborted"); });
    plant.run_for(500ms);
    plant.axis->abort();
    plant.run();
    CHECK_FALSE(plant.axis->moving());
    CHECK(plant.home() == HomingResult::Homed);
    CHECK(plate_above_switch(plant) == 0);
  }
}

TEST_CASE("Moves end on the nearest microstep, in any direction and after any number of moves") {
  CHECK(rc::check([] {
    BuiltPlant plant;
    RC_ASSERT(plant.home() == HomingResult::Homed);
    for (int i = 0; i < 3; ++i) {
      const double target = draw_real(0, 5);
      RC_ASSERT(plant.move_to(target, draw_real(0.5, 20)) == MoveResult::Reached);
      RC_ASSERT(std::llabs(plate_above_switch(plant) * 1'250 - mm(target).count()) <= 625);
      RC_ASSERT(plant.axis->height() == Nanometers{plate_above_switch(plant) * 1'250});
    }
  }));
}

TEST_CASE("Moves beyond the travel are refused without a step") {
  HomedPlant plant;
  plant.pulses.clear();
  CHECK(plant.move_to(100.001) == MoveResult::OutsideTravel);
  CHECK(plant.move_to(-0.001) == MoveResult::OutsideTravel);
  CHECK(plant.pulses.empty());
  CHECK(plant.axis->height() == Nanometers{0});
}

TEST_CASE("A move takes its predicted time") {
  HomedPlant plant;
  const TimePoint start = plant.clock.now();
  REQUIRE(plant.move_to(10) == MoveResult::Reached);
  const Duration foretold = plant.axis->move_duration(mm(10), MillimetersPerSecond{5});
  // The last step comes before the end of the curve by sqrt(1 step / 40,000 steps/s^2) = 5 ms.
  CHECK(std::chrono::abs(plant.clock.now() - start - foretold) <= 6ms);
}

TEST_CASE("A move is limited to the axis' top speed") {
  HomedPlant plant;
  plant.pulses.clear();
  REQUIRE(plant.move_to(20, 1000) == MoveResult::Reached);
  Duration shortest = 1s;
  for (std::size_t i = 1; i < plant.pulses.size(); ++i)
    shortest = std::min(shortest, plant.pulses[i] - plant.pulses[i - 1]);
  CHECK(shortest >= 125us - 1ns);  // 10 mm/s, rounded to a nanosecond
}

TEST_CASE("Pulses, pauses and direction changes keep their minimum times") {
  GpioAxisConfig c = screw_config();
  c.pulse_width = 10us;
  c.direction_setup = 5ms;
  Plant plant(c);
  plant.latency = 0ns;
  plant.build_homed();
  REQUIRE(plant.move_to(5, 10) == MoveResult::Reached);
  CHECK(plant.shortest_pulse == 10us);
  CHECK(plant.shortest_pause >= 10us);
  CHECK(plant.shortest_setup >= 5ms);
}

TEST_CASE("A top speed at which the pulses do not fit is refused with its figures") {
  GpioAxisConfig c = screw_config();
  c.pulse_width = 100us;
  CHECK(contradiction(c) ==
        "the axis' top speed of 10 mm/s is 8000 steps/s; pulses and pauses of 100 us allow at most 3750");
  Plant plant(c);
  CHECK_THROWS_AS(plant.build(), HardwareError);
  CHECK_FALSE(contradiction(screw_config()));
  c = screw_config();
  c.top_speed = MillimetersPerSecond{62.5};
  CHECK(contradiction(c) ==
        "the axis' top speed of 62.5 mm/s is 50000 steps/s; a computer makes at most 20000");
}

TEST_CASE("The motor is enabled and settles before the first step, and stays enabled") {
  BuiltPlant plant(with_enable());
  CHECK_FALSE(plant.enable->level);
  const TimePoint start = plant.clock.now();
  REQUIRE(plant.home() == HomingResult::Homed);
  CHECK(plant.pulses.front() - start >= 10ms);
  CHECK(plant.disabled_steps == 0);
  CHECK(plant.enable->level);
}

TEST_CASE("An enable line that cannot be set is a fault, and no step is made") {
  BuiltPlant plant(with_enable());
  plant.enable->refuses = true;
  CHECK(plant.home() == HomingResult::Fault);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "line 22 of gpiochip0"));
  CHECK(plant.pulses.empty());
}

TEST_CASE("A step line that cannot be set is a fault") {
  BuiltPlant plant;
  const auto refuse = plant.clock.call_after(500ms, [&] { plant.step->refuses = true; });
  CHECK(plant.home() == HomingResult::Fault);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "line 17 of gpiochip0"));
}

TEST_CASE("Stop slows down, and the position stays known") {
  HomedPlant plant;
  plant.pulses.clear();
  TimePoint asked{};
  const auto stop = plant.clock.call_after(2s, [&] {
    asked = plant.clock.now();
    plant.axis->stop();
  });
  CHECK(plant.move_to(50) == MoveResult::Stopped);
  // 5 mm/s at 50 mm/s^2 takes a tenth of a second, plus up to 10 ms until the thread notices.
  CHECK(plant.clock.now() - asked <= 115ms);
  CHECK(plant.clock.now() - asked >= 80ms);
  CHECK(plant.axis->height() == Nanometers{plate_above_switch(plant) * 1'250});
  CHECK(plant.pulses.back() - plant.pulses[plant.pulses.size() - 2] > 1ms);  // very slow by then
  CHECK(plant.move_to(1) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 800);
}

TEST_CASE("A stop at any moment of homing ends it soon") {
  CHECK(rc::check([] {
    BuiltPlant plant;
    std::optional<HomingResult> result;
    TimePoint asked{};
    auto stop = plant.clock.call_after(std::chrono::milliseconds{draw(0, 5'000)}, [&] {
      asked = plant.clock.now();
      plant.axis->stop();
    });
    result = plant.home();
    RC_ASSERT(result == HomingResult::Stopped || result == HomingResult::Homed);
    if (result == HomingResult::Stopped) RC_ASSERT(plant.clock.now() - asked <= 130ms);
    RC_ASSERT(!plant.axis->moving());
    stop.reset();
    RC_ASSERT(plant.home() == HomingResult::Homed);
    RC_ASSERT(plate_above_switch(plant) == 0);
  }));
}

TEST_CASE("An abort makes no further step and drops the answer and the position") {
  HomedPlant plant;
  bool answered = false;
  plant.axis->move_to(mm(50), MillimetersPerSecond{5}, [&](MoveResult) { answered = true; });
  plant.run_for(1s);
  plant.axis->abort();
  const std::size_t made = plant.pulses.size();
  plant.run_for(1s);
  CHECK(plant.pulses.size() == made);
  CHECK_FALSE(answered);
  CHECK_FALSE(plant.axis->moving());
  CHECK_FALSE(plant.axis->height());
  CHECK(plant.move_to(1) == MoveResult::NotHomed);
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE("Homing right after the abort of a slow move waits for that move's end") {
  HomedPlant plant;
  plant.axis->move_to(mm(50), MillimetersPerSecond{0.01}, [](MoveResult) {});
  plant.run_for(1s);
  plant.axis->abort();
  CHECK(plant.home() == HomingResult::Homed);
}

TEST_CASE("An abort while nothing moves leaves the position known") {
  HomedPlant plant;
  plant.axis->abort();
  CHECK(plant.axis->height() == Nanometers{0});
}

TEST_CASE("Backlash is taken up from below") {
  GpioAxisConfig c = screw_config();
  c.backlash = mm(0.05);  // 40 steps
  Plant plant(c);
  plant.slack = 40;
  plant.build_homed();
  CHECK(plate_above_switch(plant) == 0);
  for (const double target : {10.0, 5.0, 7.5, 2.0, 2.0, 0.0, 0.1}) {
    REQUIRE(plant.move_to(target) == MoveResult::Reached);
    CHECK(plate_above_switch(plant) == std::llround(target * 800));
    CHECK(plant.axis->height() == mm(target));
    CHECK(plant.plate() == plant.motor);  // the plate rests on the screw
  }
}

TEST_CASE("The plate's height is correct wherever a move with backlash is stopped") {
  CHECK(rc::check([] {
    GpioAxisConfig c = screw_config();
    c.backlash = mm(0.05);
    Plant plant(c);
    plant.slack = 40;
    plant.build();
    RC_ASSERT(plant.home() == HomingResult::Homed);
    RC_ASSERT(plant.move_to(3) == MoveResult::Reached);
    for (int i = 0; i < 4; ++i) {
      const auto stop =
          plant.clock.call_after(std::chrono::milliseconds{draw(1, 900)}, [&] { plant.axis->stop(); });
      (void)plant.move_to(draw_real(0, 6));
      RC_ASSERT(plant.axis->height() == Nanometers{plate_above_switch(plant) * 1'250});
    }
    RC_ASSERT(plant.move_to(4) == MoveResult::Reached);
    RC_ASSERT(plate_above_switch(plant) == 3'200);
  }));
}

TEST_CASE("The height during a move follows the past and the planned steps") {
  HomedPlant plant;
  std::vector<std::pair<TimePoint, Nanometers>> seen, foretold;
  const TimePoint start = plant.clock.now();
  std::vector<std::unique_ptr<Timer>> looks;
  for (int i = 1; i < 20; ++i) {
    looks.push_back(plant.clock.call_after(i * 100ms, [&] {
      const TimePoint now = plant.clock.now();
      CHECK(plant.axis->height() == Nanometers{plate_above_switch(plant) * 1'250});
      seen.emplace_back(now, *plant.axis->height());
      foretold.emplace_back(now + 50ms, *plant.axis->height_at(now + 50ms));
      for (const auto& [then, height] : seen)
        CHECK(plant.axis->height_at(then) == height);
      for (const auto& [then, height] : foretold) {
        if (then > now) continue;
        // The thread is usually 20 us late, which is less than a step at 4,000 steps/s, either way.
        CHECK(std::llabs((*plant.axis->height_at(then) - height).count()) <= 1'250);
      }
    }));
  }
  REQUIRE(plant.move_to(10) == MoveResult::Reached);
  CHECK(plant.axis->height_at(start - 1s) == Nanometers{0});
  CHECK(plant.axis->height_at(plant.clock.now() + 1s) == mm(10));
}

TEST_CASE("Late steps shift the rest of the move and never come in a burst") {
  CHECK(rc::check([] {
    BuiltPlant plant;
    RC_ASSERT(plant.home() == HomingResult::Homed);
    plant.pulses.clear();
    const LateSteps before = plant.axis->late_steps();
    const std::int64_t every = draw(3, 200);
    std::int64_t count = 0;
    // Shorter than 16 intervals, so the motor does not come to rest.
    const Duration delay = std::chrono::microseconds{draw(100, 3'900)};
    const bool late_falls = draw(0, 1) != 0;
    plant.step_latency = [&] {
      if (plant.step->level && !late_falls) return Duration{10'000};
      return ++count % every == 0 ? delay : Duration{10'000};
    };
    RC_ASSERT(plant.move_to(2, 5) == MoveResult::Reached);
    RC_ASSERT(std::ssize(plant.pulses) == 1'600);
    const Duration planned = 250us;  // at 4,000 steps/s, the shortest of the move
    for (std::size_t i = 1; i < plant.pulses.size(); ++i)
      RC_ASSERT(plant.pulses[i] - plant.pulses[i - 1] >= planned * 3 / 4);
    if (!late_falls) {
      RC_ASSERT(plant.axis->late_steps().count > before.count);
      RC_ASSERT(plant.axis->late_steps().worst >= delay);
    }
    RC_ASSERT(plate_above_switch(plant) == 1'600);
  }));
}

TEST_CASE("A limit switch that closes in the middle of a move halts it as a fault") {
  HomedPlant plant;
  std::size_t made = 0;
  const auto press = plant.clock.call_after(2s, [&] {
    plant.limit.stuck = true;
    made = plant.pulses.size();
  });
  CHECK(plant.move_to(50) == MoveResult::Fault);
  // 5 ms of debouncing plus 0.1 ms of latency are 21 steps.
  CHECK(plant.pulses.size() - made <= 22);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault,
                        "the limit switch (line 23 of gpiochip0) is closed at"));
  CHECK_FALSE(plant.axis->height());
}

TEST_CASE("A limit switch may close at its own height in a move") {
  Plant plant(screw_config());
  plant.limit.hysteresis = 400;
  plant.build_homed();
  CHECK(plant.move_to(10) == MoveResult::Reached);
  CHECK(plant.move_to(0) == MoveResult::Reached);
  CHECK(plant.move_to(10) == MoveResult::Reached);
  CHECK(plant.events.empty());
}

TEST_CASE("The second switch halts a move as a fault") {
  Plant plant(with_second_switch());
  plant.second.at = 40'000;
  plant.build_homed();
  CHECK(plant.move_to(60) == MoveResult::Fault);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "(line 24 of gpiochip0) closed at 50."));
  plant.events.clear();
  CHECK(plant.home() == HomingResult::Homed);  // away from the second switch, which is still closed
  CHECK(plate_above_switch(plant) == 0);
}

TEST_CASE("With an encoder the height is the measured one") {
  HomedPlant plant(with_encoder(EncoderConfig::Policy::Fault));
  int lost = 0;
  plant.loses_step = [&] { return lost < 20 && ++lost > 0; };  // 25 um: within the tolerance of 50
  CHECK(plant.move_to(10) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 7'980);
  CHECK(plant.axis->height() == mm(9.975));
  CHECK(plant.events.empty());
}

TEST_CASE("Steps lost beyond the tolerance are a fault while the motor turns") {
  HomedPlant plant(with_encoder(EncoderConfig::Policy::Fault));
  plant.pulses.clear();
  const auto dies = plant.clock.call_after(2s, [&] { plant.dead = true; });
  CHECK(plant.move_to(50) == MoveResult::Fault);
  // 50 um plus the distance at top speed in 5 ms are 80 steps; 10 ms until the check add 40.
  CHECK(plant.pulses.size() <= std::size_t{7'800 + 130});
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "the encoder measures"));
  CHECK_FALSE(plant.axis->height());
}

TEST_CASE("A dead motor is noticed while homing") {
  Plant plant(with_encoder(EncoderConfig::Policy::Correct));
  plant.dead = true;
  plant.build();
  CHECK(plant.home() == HomingResult::NoMovement);
  CHECK(plant.pulses.size() < 200);
  CHECK(only_event_says(plant, MachineEvent::Kind::Fault, "the encoder measures 0.000 mm but"));
}

TEST_CASE("Lost steps are corrected with the policy Correct") {
  HomedPlant plant(with_encoder(EncoderConfig::Policy::Correct));
  int lost = 0;
  plant.loses_step = [&] { return lost < 100 && ++lost > 0; };
  CHECK(plant.move_to(10) == MoveResult::Reached);
  CHECK(plate_above_switch(plant) == 8'000);
  CHECK(plant.axis->height() == mm(10));
}

TEST_CASE("A motor that dies is a fault even with the policy Correct") {
  HomedPlant plant(with_encoder(EncoderConfig::Policy::Correct));
  plant.dead = true;
  plant.pulses.clear();
  CHECK(plant.move_to(0.2) == MoveResult::Fault);  // short enough for one correction to be tried
  CHECK(plant.pulses.size() == 2 * 160);
  REQUIRE(plant.events.size() == 2);
  CHECK(plant.events[0].kind == MachineEvent::Kind::Notice);
  CHECK(plant.events[1].kind == MachineEvent::Kind::Fault);
}

TEST_CASE("A wrongly reversed encoder ends homing as no movement") {
  GpioAxisConfig c = with_encoder(EncoderConfig::Policy::Fault);
  c.encoder->reversed = true;
  BuiltPlant plant(c);
  CHECK(plant.home() == HomingResult::NoMovement);
}

TEST_CASE("Homing and moves with an encoder and backlash agree") {
  GpioAxisConfig c = with_encoder(EncoderConfig::Policy::Fault);
  c.backlash = mm(0.1);
  Plant plant(c);
  plant.slack = 80;
  plant.build_homed();
  for (const double target : {10.0, 5.0, 0.0}) {
    CHECK(plant.move_to(target) == MoveResult::Reached);
    CHECK(plate_above_switch(plant) == std::llround(target * 800));
    CHECK(plant.axis->height() == mm(target));
  }
  CHECK(plant.events.empty());
}

TEST_CASE("An axis whose motor was released has no known height until it has homed again") {
  Plant plant(with_enable());
  GpioAxis& axis = plant.build_homed();
  CHECK(axis.release());
  CHECK_FALSE(plant.enable->level);
  CHECK_FALSE(axis.height());
  CHECK(plant.move_to(1) == MoveResult::NotHomed);
  CHECK(plant.home() == HomingResult::Homed);
  CHECK(plant.enable->level);
  Plant without(screw_config());
  GpioAxis& other = without.build_homed();
  CHECK_FALSE(other.release());
  CHECK(other.height());
}

TEST_CASE("An axis reports the name, the line, the level and the edges of its inputs") {
  GpioAxisConfig c = with_encoder(EncoderConfig::Policy::Fault, with_second_switch());
  c.encoder->a.line = "5";
  c.lid = GpioInputConfig{{"gpiochip1", "LID", false}};
  Plant plant(c);
  GpioAxis& axis = plant.build();
  CHECK(plant.home() == HomingResult::Homed);
  plant.press(AxisInput::Lid, true);
  plant.lines[static_cast<std::size_t>(AxisInput::SecondSwitch)]->unreadable = true;
  const std::vector<AxisInputState> inputs = axis.inputs();
  REQUIRE(inputs.size() == 5);
  CHECK(inputs[0].name == "limit switch");
  CHECK(inputs[0].line == "line 23 of gpiochip0");
  CHECK(inputs[0].active == true);
  CHECK(inputs[0].edges == 3);  // closed, open, closed
  CHECK(inputs[1].name == "second switch");
  CHECK_FALSE(inputs[1].active);
  CHECK(inputs[2].name == "lid");
  CHECK(inputs[2].line == "line LID of gpiochip1");
  CHECK(inputs[2].active == true);
  CHECK(inputs[3].name == "encoder A");
  CHECK(inputs[3].line == "line 5 of gpiochip0");
  // Each count is an edge on one of the encoder's lines.
  CHECK(inputs[3].edges > 1000);
  CHECK(inputs[4].edges > 1000);
}
