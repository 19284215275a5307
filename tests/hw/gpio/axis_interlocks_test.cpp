// Tests of AxisInterlocks: the test serves the inputs and records the calls to the motor.
#include "hw/gpio/axis_interlocks.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::PlantInput;
using testing::PlantOutput;

namespace {

TimePoint bench_time{};  // global because AxisInputs takes a plain function

using Words = std::vector<std::string>;

struct Bench {
  Bench() {
    bench_time = TimePoint{1s};
    config.limit_switch.line.line = "23";
    config.second_switch = GpioInputConfig{{"gpiochip0", "24", false}};
    config.emergency_stop = GpioInputConfig{{"gpiochip0", "25", false}};
    config.lid = GpioInputConfig{{"gpiochip0", "26", false}};
    inputs.serve();
  }

  // Runs the input thread for `time`, then the event loop.
  void pass(Duration time = 6ms) {
    for (const TimePoint end = bench_time + time; bench_time < end; bench_time += 1ms)
      inputs.serve();
    interlocks.take_changes();
  }
  void set(AxisInput which, bool active) {
    lines[static_cast<std::size_t>(which)].set(active, bench_time);
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
                  did.push_back((fault.owner_decides ? "owner's fault: " : "fault: ") + fault.what);
                  results.push_back(fault.homing);
                },
            .report =
                [this](const MachineEvent& event) {
                  const char* const kind = event.kind == MachineEvent::Kind::Recovery
                                               ? event.owner_decides ? "owner's recovery: " : "recovery: "
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
            .where = [] { return std::string(" at 1.000 mm"); }};
  }

  GpioAxisConfig config;
  bool homes = false;
  Words did;
  std::vector<HomingResult> results;
  std::array<PlantInput, kAxisInputs> lines;
  PlantOutput step, direction;
  StepEngine engine{step, direction, {}, []() noexcept { return bench_time; }};
  AxisInputs inputs{engine, input_lines(), []() noexcept { return bench_time; }};
  AxisInterlocks interlocks{config, engine, inputs, wiring()};
};

}  // namespace

TEST_CASE("An emergency stop slows the motor at its first edge, is a fault if it lasts, and is released") {
  Bench bench;
  bench.set(AxisInput::EmergencyStop, true);
  CHECK(bench.told() == Words{"slow down",
                              "interruption: the emergency stop was touched, or its line disturbed (line 25 "
                              "of gpiochip0)"});
  bench.pass();
  CHECK(bench.told() == Words{"owner's fault: the emergency stop is pressed (line 25 of gpiochip0)"});
  CHECK(bench.engine.inhibited());
  CHECK(bench.interlocks.why_not_ready() == Words{"the emergency stop is pressed"});
  bench.set(AxisInput::EmergencyStop, false);
  bench.pass();
  CHECK(bench.told() == Words{"owner's recovery: the emergency stop was released (line 25 of gpiochip0)"});
  CHECK_FALSE(bench.engine.inhibited());
  CHECK(bench.interlocks.why_not_ready().empty());
}

TEST_CASE("An emergency stop that does not last ends without a fault") {
  Bench bench;
  bench.set(AxisInput::EmergencyStop, true);
  bench.set(AxisInput::EmergencyStop, false);
  bench.told();
  bench.pass();
  CHECK(bench.told() == Words{"recovery: the emergency stop is not pressed (line 25 of gpiochip0)"});
}

TEST_CASE("A pressed emergency stop that has blocked a motion is reported once") {
  Bench bench;
  bench.set(AxisInput::EmergencyStop, true);
  bench.told();
  for (int i = 0; i < 6; ++i, bench_time += 1ms)
    bench.inputs.serve();
  REQUIRE(bench.engine.inhibited());
  bench.interlocks.blocked();
  CHECK(bench.told().size() == 1);
  bench.pass();
  CHECK(bench.told().empty());
  // When it is pressed again it is reported again.
  bench.set(AxisInput::EmergencyStop, false);
  bench.pass();
  bench.told();
  bench.set(AxisInput::EmergencyStop, true);
  bench.pass();
  CHECK(bench.told().back() == "owner's fault: the emergency stop is pressed (line 25 of gpiochip0)");
}

TEST_CASE("An open lid interrupts at its first edge, does not halt the motor, and its closing is reported") {
  Bench bench;
  bench.set(AxisInput::Lid, true);
  CHECK(bench.told() == Words{"interruption: the lid was opened (line 26 of gpiochip0)"});
  bench.pass();
  CHECK(bench.told().empty());
  CHECK(bench.interlocks.why_not_ready() == Words{"the lid is open"});
  bench.set(AxisInput::Lid, false);
  bench.pass();
  CHECK(bench.told() == Words{"recovery: the lid was closed (line 26 of gpiochip0)"});
  CHECK_FALSE(bench.engine.inhibited());
}

TEST_CASE("A safety input that cannot be read is reported as unreadable") {
  Bench bench;
  bench.lines[static_cast<std::size_t>(AxisInput::Lid)].unreadable = true;
  bench.lines[static_cast<std::size_t>(AxisInput::EmergencyStop)].unreadable = true;
  // Levels are read every 20 ms; the event loop runs as often as the input thread.
  for (int i = 0; i < 40; ++i)
    bench.pass(1ms);
  const Words told = bench.told();
  const auto was_reported = [&told](const std::string& words) {
    return std::ranges::find(told, words) != told.end();
  };
  CHECK(was_reported("interruption: the emergency stop cannot be read (line 25 of gpiochip0)"));
  CHECK(was_reported("interruption: the lid cannot be read, which counts as open (line 26 of gpiochip0)"));
  CHECK(was_reported("owner's fault: the emergency stop cannot be read (line 25 of gpiochip0)"));
  CHECK(bench.interlocks.why_not_ready() ==
        Words{"the emergency stop cannot be read", "the lid cannot be read"});
}

TEST_CASE("The limit switch's contact goes to homing if that expects it, and is a fault otherwise") {
  for (const bool homes : {true, false}) {
    CAPTURE(homes);
    Bench bench;
    bench.homes = homes;
    bench.inputs.set_limit_rule(LimitRule::AtContact);
    bench.set(AxisInput::LimitSwitch, true);
    bench.pass();
    const std::string fault =
        "halted: the limit switch (line 23 of gpiochip0) is closed at 1.000 mm, where it should be open";
    CHECK(bench.told() == Words{homes ? "contact" : fault});
    CHECK(bench.results == (homes ? std::vector<HomingResult>{} : std::vector{HomingResult::Fault}));
  }
}

TEST_CASE("Switches that have not halted a run are ignored") {
  Bench bench;
  bench.homes = true;
  bench.set(AxisInput::LimitSwitch, true);
  bench.set(AxisInput::SecondSwitch, true);
  bench.pass();
  CHECK(bench.told().empty());
}

TEST_CASE("The second switch, while it is watched, is a fault of the run that it halted") {
  Bench bench;
  bench.inputs.watch_second_switch(true);
  bench.set(AxisInput::SecondSwitch, true);
  bench.pass();
  CHECK(bench.told() == Words{"halted: the second switch (line 24 of gpiochip0) closed at 1.000 mm"});
  CHECK(bench.results == std::vector{HomingResult::WrongSwitch});
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
    Bench bench;
    if (which) {
      bench.lines[static_cast<std::size_t>(*which)].unreadable = true;
    } else {
      bench.inputs.lose();
    }
    bench.pass(40ms);
    CHECK(bench.told() == Words{fault});
    bench.pass(40ms);
    CHECK(bench.told().empty());
    CHECK(bench.engine.inhibited());
  }
}
