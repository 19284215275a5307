// Tests of AxisDrive alone: the test runs the engine and serves the inputs. PlateApproach is tested here too,
// since it only makes runs.
#include "hw/gpio/axis_drive.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hw/gpio/plate_approach.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using testing::PlantInput;
using testing::PlantOutput;

namespace {

using RunKind = AxisDrive::RunKind;
using Words = std::vector<std::string>;

constexpr MillimetersPerSecond kSpeed{5};

GpioAxisConfig axis_config(Nanometers backlash = Nanometers{0}) {
  GpioAxisConfig config;
  config.step.line = "17";
  config.direction.line = "27";
  config.enable = GpioLineConfig{"gpiochip0", "22", false};
  config.backlash = backlash;
  return config;
}

struct Bench {
  explicit Bench(GpioAxisConfig given = axis_config()) : config(std::move(given)) {
    testing::plant_clock = &clock;
    inputs.serve();
  }
  ~Bench() { testing::plant_clock = nullptr; }

  // Runs the step thread to the end of the move or for `steps` steps; then the event loop.
  void turn(std::int64_t steps = 1'000'000) {
    const std::int64_t from = engine.position();
    bool running = engine.running() || engine.begin();
    while (running && std::abs(engine.position() - from) < steps) {
      wait_until(engine.interrupted() ? clock.now() + Duration{100} : engine.due());
      engine.act();
      running = engine.running();
    }
    if (!engine.moving()) drive.engine_ended();
  }
  void wait_until(TimePoint time) {
    bool over = false;
    const auto timer = clock.call_at(std::max(time, clock.now()), [&] { over = true; });
    while (!over)
      clock.run_next();
  }
  void wait(Duration time) { wait_until(clock.now() + time); }
  void press(bool active) {
    stop.set(active, clock.now());
    inputs.serve();
  }
  void begin() {
    drive.begin([this] { did.emplace_back("ready"); });
    wait(config.enable_settle);
  }
  void run(RunKind kind, std::int64_t steps) {
    drive.run(kind, Microsteps{steps}, kSpeed, [this] { did.emplace_back("over"); });
  }
  Words done() { return std::exchange(did, {}); }

  AxisDrive::Wiring wiring() {
    return {.fail =
                [this](const AxisFault& fault) {
                  did.push_back("fault: " + fault.what);
                  drive.halt();
                },
            .notice = [this](const std::string& what) { did.push_back("notice: " + what); },
            .stopped = [this] { did.emplace_back("stopped"); },
            .blocked = [this] { did.emplace_back("blocked"); },
            .take_changes =
                [this] {
                  if (cause) drive.halted_for(*cause);
                },
            .take_contact = [this] { return std::exchange(contact, false); }};
  }
  AxisInputs::Lines input_lines() {
    AxisInputs::Lines lines;
    lines.contacts[static_cast<std::size_t>(AxisInput::LimitSwitch)] = {&limit, 5ms};
    lines.contacts[static_cast<std::size_t>(AxisInput::EmergencyStop)] = {&stop, 5ms};
    return lines;
  }

  VirtualClock clock;
  GpioAxisConfig config;
  Words did;
  std::optional<AxisFault> cause;
  bool contact = false;
  PlantOutput step, direction, enable;
  PlantInput limit, stop;
  StepEngine engine{step, direction, {}, testing::plant_now};
  AxisInputs inputs{engine, input_lines(), testing::plant_now};
  PlatePosition position{config, engine, inputs};
  AxisDrive drive{clock, config, &enable, engine, inputs, position, wiring()};
  PlateApproach approach{drive, position, {wiring().fail, wiring().notice}};
};

}  // namespace

TEST_CASE("A motion begins when the motor is enabled and has settled, and the next one at once") {
  Bench bench;
  bench.drive.begin([&bench] { bench.did.emplace_back("ready"); });
  CHECK(bench.enable.level);
  CHECK(bench.done().empty());
  bench.wait(bench.config.enable_settle);
  CHECK(bench.done() == Words{"ready"});
  bench.drive.forget();
  bench.drive.begin([&bench] { bench.did.emplace_back("ready"); });
  CHECK(bench.done() == Words{"ready"});
}

TEST_CASE("A run makes its steps and then calls its callback, which may begin the next run") {
  Bench bench;
  bench.begin();
  bench.drive.run(RunKind::Move, Microsteps{300}, kSpeed, [&bench] { bench.run(RunKind::Move, -100); });
  bench.turn();
  CHECK(bench.engine.position() == 300);
  CHECK(bench.done() == Words{"ready"});
  bench.turn();
  CHECK(bench.engine.position() == 200);
  CHECK(bench.done() == Words{"over"});
  CHECK_FALSE(bench.drive.turning());
}

TEST_CASE("A stop slows a run down and is answered when the motor rests, or at once if it rests already") {
  Bench bench;
  bench.begin();
  bench.run(RunKind::Move, 20'000);
  bench.turn(1'000);
  bench.drive.stop();
  CHECK(bench.done() == Words{"ready"});
  bench.turn();
  CHECK(bench.done() == Words{"stopped"});
  CHECK(bench.engine.position() > 1'000);
  CHECK(bench.engine.position() < 20'000);

  bench.drive.forget();
  bench.begin();
  bench.done();
  bench.drive.stop();
  bench.wait(1ms);
  CHECK(bench.done() == Words{"stopped"});
}

TEST_CASE("A run that was slowed down continues to its end when the emergency stop has settled") {
  Bench bench;
  bench.begin();
  bench.run(RunKind::Move, 20'000);
  bench.turn(1'000);
  bench.press(true);
  bench.press(false);
  bench.drive.slow_down();
  bench.turn();
  bench.drive.go_on();
  CHECK_FALSE(bench.engine.moving());
  bench.wait(6ms);
  bench.inputs.serve();
  bench.drive.go_on();
  bench.turn();
  CHECK(bench.engine.position() == 20'000);
  CHECK(bench.done() == Words{"ready", "over"});
}

TEST_CASE("A halted run ends with the fault that halted it, even if a contact has come") {
  Bench bench;
  bench.begin();
  bench.done();
  bench.run(RunKind::Seek, -20'000);
  bench.turn(1'000);
  bench.contact = true;
  bench.cause = AxisFault{HomingResult::WrongSwitch, "the wrong switch", false};
  bench.engine.halt_soon();
  bench.turn();
  CHECK(bench.done() == Words{"fault: the wrong switch"});
  CHECK(bench.engine.position() == -1'000);
}

TEST_CASE("A pass that the limit switch's edge halts waits for the contact, and can be continued") {
  Bench bench;
  bench.begin();
  bench.done();
  bench.run(RunKind::Seek, -2'000);
  bench.turn(1'000);
  bench.limit.set(true, bench.clock.now());
  bench.inputs.serve();
  bench.turn();
  CHECK(bench.engine.position() == -1'000);
  CHECK(bench.done().empty());
  bench.limit.set(false, bench.clock.now());
  bench.wait(6ms);
  bench.inputs.serve();
  bench.drive.end_run();
  bench.drive.run_on();
  bench.turn();
  CHECK(bench.engine.position() == -2'000);
  CHECK(bench.done() == Words{"over"});
}

TEST_CASE("A contact that has come by the end of a pass is handled instead of the end") {
  Bench bench;
  bench.begin();
  bench.done();
  bench.run(RunKind::Seek, -500);
  bench.contact = true;
  bench.turn();
  CHECK(bench.done().empty());
}

TEST_CASE("An inhibited motor does not turn and is reported as blocked") {
  Bench bench;
  bench.engine.inhibit();
  bench.drive.begin([&bench] { bench.did.emplace_back("ready"); });
  CHECK(bench.done().empty());
  bench.wait(1ms);
  CHECK(bench.done() == Words{"blocked"});
  CHECK_FALSE(bench.enable.level);

  bench.engine.enable();
  bench.begin();
  bench.run(RunKind::Move, 1'000);
  bench.turn(100);
  bench.engine.inhibit();
  bench.turn();
  CHECK(bench.done() == Words{"ready", "blocked"});
  CHECK(bench.engine.position() == 100);
}

TEST_CASE("A line that cannot be set is a fault that names it, and line_refused() stays true") {
  Bench bench;
  bench.begin();
  bench.done();
  bench.step.refuses = true;
  CHECK_FALSE(bench.drive.line_refused());
  bench.run(RunKind::Move, 1'000);
  bench.turn();
  CHECK(bench.done() == Words{"fault: the kernel refuses to set the step line, line 17 of gpiochip0, or the "
                              "direction line, line 27 of gpiochip0"});
  CHECK(bench.drive.line_refused());

  Bench other;
  other.enable.refuses = true;
  other.begin();
  CHECK(other.done() ==
        Words{"fault: the kernel refuses to set the motor's enable line, line 22 of gpiochip0"});
  CHECK(other.drive.line_refused());
}

TEST_CASE("A halt makes no further step and forgets the position, and a new motion waits for the run's end") {
  Bench bench;
  bench.position.become_known();
  bench.begin();
  bench.done();
  bench.run(RunKind::Move, 20'000);
  bench.turn(1'000);
  bench.drive.halt();
  CHECK_FALSE(bench.position.known());
  bench.begin();
  CHECK(bench.done().empty());
  bench.turn();
  CHECK(bench.done() == Words{"ready"});
  CHECK(bench.engine.position() == 1'000);
}

TEST_CASE("The plate approaches a position from below if the screw has play") {
  Bench bench(axis_config(Nanometers{50'000}));  // 40 steps
  bench.position.become_known();
  bench.begin();
  bench.approach.begin(Microsteps{1'000}, kSpeed, [&bench] { bench.did.emplace_back("there"); });
  bench.turn();
  CHECK(bench.done() == Words{"ready", "there"});
  CHECK(bench.position.by_steps().plate() == Microsteps{1'000});

  bench.approach.begin(Microsteps{500}, kSpeed, [&bench] { bench.did.emplace_back("there"); });
  bench.turn();
  CHECK(bench.engine.position() == 460);
  CHECK(bench.done().empty());
  bench.turn();
  CHECK(bench.done() == Words{"there"});
  CHECK(bench.position.by_steps().plate() == Microsteps{500});
  CHECK(bench.position.by_steps().play == Microsteps{0});
}
