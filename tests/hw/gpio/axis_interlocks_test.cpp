// Tests of AxisInterlocks: the test serves the inputs and records the calls to the motor.
#include "hw/gpio/axis_interlocks.hpp"

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/gpio/test_time.hpp"

namespace {

using Words = std::vector<std::string>;

struct InterlocksFixture {
  InterlocksFixture() {
    test_time = TimePoint{1s};
    config.limit_switch.line.line = "23";
    config.second_switch = GpioInputConfig{{"gpiochip0", "24", false}};
    config.emergency_stop = GpioInputConfig{{"gpiochip0", "25", false}};
    config.lid = GpioInputConfig{{"gpiochip0", "26", false}};
    config.power_fail = GpioInputConfig{{"gpiochip0", "16", false}};
    inputs.serve();
  }

  // Runs the input thread for `time`, then the event loop.
  void pass(Duration time = 6ms) {
    for (const TimePoint end = test_time + time; test_time < end; test_time += 1ms)
      inputs.serve();
    interlocks.take_changes();
  }
  void set(AxisInput which, bool active) {
    lines[static_cast<std::size_t>(which)].set(active, test_time);
    pass(1ms);
  }
  // Returns the calls and reports since the last call.
  Words told() { return std::exchange(did, {}); }

  AxisInputs::Lines input_lines() {
    AxisInputs::Lines all;
    for (std::size_t i = 0; i < kAxisInputs; ++i)
      all.contacts[i] = {&lines[i], 5ms};
    return all;
  }
  AxisInterlocks::Wiring wiring() {
    return {.fail =
                [this](const AxisFault& fault) {
                  did.push_back((fault.needs_user ? "user's fault: " : "fault: ") + fault.what);
                  results.push_back(fault.homing);
                },
            .report =
                [this](const MachineEvent& event) {
                  const char* const kind = event.kind == MachineEvent::Kind::Recovery
                                               ? event.needs_user ? "user's recovery: " : "recovery: "
                                               : "interruption: ";
                  did.push_back(kind + event.what);
                },
            .slow_down = [this] { did.emplace_back("slow down"); },
            .halted_for =
                [this](const AxisFault& fault) {
                  did.push_back("halted: " + fault.what);
                  results.push_back(fault.homing);
                },
            .takes_contact =
                [this](const InputChange& change) {
                  if (homes) did.emplace_back(change.active ? "contact" : "spike");
                  return homes;
                },
            .where = [] { return std::string(" at 1.000 mm"); },
            .force_changed =
                [this](const InputChange& change) {
                  did.emplace_back(change.halted ? "resistance" : change.active ? "force" : "no force");
                }};
  }

  GpioAxisConfig config;
  bool homes = false;
  Words did;
  std::vector<HomingResult> results;
  std::array<PlantInput, kAxisInputs> lines;
  PlantOutput step, direction;
  StepEngine engine{step, direction, {}, testing::test_now};
  AxisInputs inputs{engine, input_lines(), testing::test_now};
  AxisInterlocks interlocks{config, engine, inputs, wiring()};
};

}  // namespace

TEST_CASE_METHOD(
    InterlocksFixture,
    "An emergency stop slows the motor at its first edge, is a fault if it lasts, and is released") {
  set(AxisInput::EmergencyStop, true);
  CHECK(told() == Words{"slow down",
                        "interruption: the emergency stop was touched, or its line disturbed (line 25 "
                        "of gpiochip0)"});
  pass();
  CHECK(told() == Words{"user's fault: the emergency stop is pressed (line 25 of gpiochip0)"});
  CHECK(engine.inhibited());
  CHECK(interlocks.why_not_ready() == Words{"the emergency stop is pressed"});
  set(AxisInput::EmergencyStop, false);
  pass();
  CHECK(told() == Words{"user's recovery: the emergency stop was released (line 25 of gpiochip0)"});
  CHECK_FALSE(engine.inhibited());
  CHECK(interlocks.why_not_ready().empty());
}

TEST_CASE_METHOD(InterlocksFixture, "An emergency stop that does not last ends without a fault") {
  set(AxisInput::EmergencyStop, true);
  set(AxisInput::EmergencyStop, false);
  told();
  pass();
  CHECK(told() == Words{"recovery: the emergency stop is not pressed (line 25 of gpiochip0)"});
}

TEST_CASE_METHOD(InterlocksFixture, "A pressed emergency stop that has blocked a motion is reported once") {
  set(AxisInput::EmergencyStop, true);
  told();
  for (int i = 0; i < 6; ++i, test_time += 1ms)
    inputs.serve();
  REQUIRE(engine.inhibited());
  interlocks.blocked();
  CHECK(told().size() == 1);
  pass();
  CHECK(told().empty());
  // When it is pressed again it is reported again.
  set(AxisInput::EmergencyStop, false);
  pass();
  told();
  set(AxisInput::EmergencyStop, true);
  pass();
  CHECK(told().back() == "user's fault: the emergency stop is pressed (line 25 of gpiochip0)");
}

TEST_CASE_METHOD(
    InterlocksFixture,
    "An open lid interrupts at its first edge, does not halt the motor, and its closing is reported") {
  set(AxisInput::Lid, true);
  CHECK(told() == Words{"interruption: the lid was opened (line 26 of gpiochip0)"});
  pass();
  CHECK(told().empty());
  CHECK(interlocks.why_not_ready() == Words{"the lid is open"});
  set(AxisInput::Lid, false);
  pass();
  CHECK(told() == Words{"recovery: the lid was closed (line 26 of gpiochip0)"});
  CHECK_FALSE(engine.inhibited());
}

TEST_CASE_METHOD(InterlocksFixture, "A failing supply interrupts at its first edge, until it is back") {
  set(AxisInput::PowerFail, true);
  CHECK(told() == Words{"interruption: the power is failing (line 16 of gpiochip0)"});
  pass();
  CHECK(told().empty());
  CHECK(interlocks.why_not_ready() == Words{"the power is failing"});
  set(AxisInput::PowerFail, false);
  pass();
  CHECK(told() == Words{"recovery: the power is back (line 16 of gpiochip0)"});
  CHECK(interlocks.why_not_ready().empty());
  CHECK_FALSE(engine.inhibited());
}

TEST_CASE_METHOD(InterlocksFixture, "A safety input that cannot be read is reported as unreadable") {
  lines[static_cast<std::size_t>(AxisInput::Lid)].unreadable = true;
  lines[static_cast<std::size_t>(AxisInput::EmergencyStop)].unreadable = true;
  // Levels are read every 20 ms; the event loop runs as often as the input thread.
  for (int i = 0; i < 40; ++i)
    pass(1ms);
  const Words reports = told();
  const auto was_reported = [&reports](const std::string& words) {
    return std::ranges::find(reports, words) != reports.end();
  };
  CHECK(was_reported("interruption: the emergency stop cannot be read (line 25 of gpiochip0)"));
  CHECK(was_reported("interruption: the lid cannot be read, which counts as open (line 26 of gpiochip0)"));
  CHECK(was_reported("user's fault: the emergency stop cannot be read (line 25 of gpiochip0)"));
  CHECK(interlocks.why_not_ready() == Words{"the emergency stop cannot be read", "the lid cannot be read"});
}

TEST_CASE("The limit switch's contact goes to homing if that expects it, and is a fault otherwise") {
  for (const bool homes : {true, false}) {
    CAPTURE(homes);
    InterlocksFixture fixture;
    fixture.homes = homes;
    fixture.inputs.set_limit_rule(LimitRule::AtContact);
    fixture.set(AxisInput::LimitSwitch, true);
    fixture.pass();
    const std::string fault =
        "halted: the limit switch (line 23 of gpiochip0) is closed at 1.000 mm, where it should be open";
    CHECK(fixture.told() == Words{homes ? "contact" : fault});
    CHECK(fixture.results == (homes ? std::vector<HomingResult>{} : std::vector{HomingResult::Fault}));
  }
}

TEST_CASE_METHOD(InterlocksFixture, "Switches that have not halted a run are ignored") {
  homes = true;
  set(AxisInput::LimitSwitch, true);
  set(AxisInput::SecondSwitch, true);
  pass();
  CHECK(told().empty());
}

TEST_CASE_METHOD(InterlocksFixture,
                 "The second switch, while it is watched, is a fault of the run that it halted") {
  inputs.watch_second_switch(true);
  set(AxisInput::SecondSwitch, true);
  pass();
  CHECK(told() == Words{"halted: the second switch (line 24 of gpiochip0) closed at 1.000 mm"});
  CHECK(results == std::vector{HomingResult::WrongSwitch});
}

TEST_CASE("The loss of the inputs is a fault that names the input, reported once") {
  const std::vector<std::pair<std::optional<AxisInput>, std::string>> losses{
      {AxisInput::LimitSwitch, "fault: the limit switch cannot be read (line 23 of gpiochip0)"},
      {AxisInput::SecondSwitch, "fault: the second switch cannot be read (line 24 of gpiochip0)"},
      {std::nullopt,
       "fault: the axis' inputs on gpiochip0 can no longer be read: their chip is gone, or they change "
       "faster than they can be handled"}};
  for (const auto& [which, fault] : losses) {
    CAPTURE(fault);
    InterlocksFixture fixture;
    if (which) {
      fixture.lines[static_cast<std::size_t>(*which)].unreadable = true;
    } else {
      fixture.inputs.lose();
    }
    fixture.pass(40ms);
    CHECK(fixture.told() == Words{fault});
    fixture.pass(40ms);
    CHECK(fixture.told().empty());
    CHECK(fixture.engine.inhibited());
  }
}

TEST_CASE_METHOD(InterlocksFixture,
                 "A force is passed on once it has settled, and one that halts as resistance") {
  set(AxisInput::Force, true);
  CHECK(told().empty());
  pass();
  CHECK(told() == Words{"force"});
  set(AxisInput::Force, false);
  pass();
  CHECK(told() == Words{"no force"});
  inputs.set_force_rule(ForceRule::Above, -1);  // the motor is at 0
  set(AxisInput::Force, true);
  pass();
  CHECK(told() == Words{"force", "resistance"});
  pass(100ms);
  CHECK(told().empty());
}
