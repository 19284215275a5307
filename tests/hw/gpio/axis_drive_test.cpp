// Tests of AxisDrive alone: the test runs the engine and serves the inputs. PlateApproach is tested here too,
// since it only makes runs.
#include "hw/gpio/axis_drive.hpp"

#include "hw/gpio/plate_approach.hpp"
#include "tests/catch.hpp"
#include "tests/hw/gpio/plant.hpp"
#include "tests/hw/virtual_time_fixture.hpp"

namespace {

using RunKind = AxisDrive::RunKind;
using Words = std::vector<std::string>;

constexpr MillimetersPerSecond kRunSpeed{5};

GpioAxisConfig drive_config(Nanometers backlash = Nanometers{0}) {
  GpioAxisConfig config;
  config.step.line = "17";
  config.direction.line = "27";
  config.enable = GpioLineConfig{"gpiochip0", "22", false};
  config.backlash = backlash;
  return config;
}

struct DriveFixture : testing::VirtualTimeFixture {
  explicit DriveFixture(GpioAxisConfig given = drive_config()) : config(std::move(given)) {
    testing::plant_clock = &clock;
    inputs.serve();
  }
  ~DriveFixture() { testing::plant_clock = nullptr; }

  // Runs the step thread to the end of the move or for `steps` steps; then the event loop.
  void turn(std::int64_t steps = 1'000'000) {
    const std::int64_t from = engine.position();
    bool running = engine.running() || engine.begin();
    while (running && std::abs(engine.position() - from) < steps) {
      pass_until(engine.interrupted() ? clock.now() + Duration{100} : engine.due());
      engine.act();
      running = engine.running();
    }
    if (!engine.moving()) drive.engine_ended();
  }
  void pass_until(TimePoint time) { pass(std::max(time, clock.now()) - clock.now()); }
  void press(bool active) {
    stop.set(active, clock.now());
    inputs.serve();
  }
  void begin() {
    drive.begin([this] { did.emplace_back("ready"); });
    pass(config.enable_settle);
  }
  void run(RunKind kind, std::int64_t steps) {
    drive.run(kind, Microsteps{steps}, kRunSpeed, [this] { did.emplace_back("over"); });
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
            .take_contact = [this] { return std::exchange(contact, false); },
            .resisted = [this] { did.emplace_back("resisted"); }};
  }
  AxisInputs::Lines input_lines() {
    AxisInputs::Lines lines;
    lines.contacts[static_cast<std::size_t>(AxisInput::LimitSwitch)] = {&limit, 5ms};
    lines.contacts[static_cast<std::size_t>(AxisInput::EmergencyStop)] = {&stop, 5ms};
    return lines;
  }

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

TEST_CASE_METHOD(DriveFixture,
                 "A motion begins when the motor is enabled and has settled, and the next one at once") {
  drive.begin([this] { did.emplace_back("ready"); });
  CHECK(enable.level);
  CHECK(done().empty());
  pass(config.enable_settle);
  CHECK(done() == Words{"ready"});
  drive.forget();
  drive.begin([this] { did.emplace_back("ready"); });
  CHECK(done() == Words{"ready"});
}

TEST_CASE_METHOD(DriveFixture,
                 "A run makes its steps and then calls its callback, which may begin the next run") {
  begin();
  drive.run(RunKind::Move, Microsteps{300}, kRunSpeed, [this] { run(RunKind::Move, -100); });
  turn();
  CHECK(engine.position() == 300);
  CHECK(done() == Words{"ready"});
  turn();
  CHECK(engine.position() == 200);
  CHECK(done() == Words{"over"});
  CHECK_FALSE(drive.turning());
}

TEST_CASE_METHOD(
    DriveFixture,
    "A stop slows a run down and is answered when the motor rests, or at once if it rests already") {
  begin();
  run(RunKind::Move, 20'000);
  turn(1'000);
  drive.stop();
  CHECK(done() == Words{"ready"});
  turn();
  CHECK(done() == Words{"stopped"});
  CHECK(engine.position() > 1'000);
  CHECK(engine.position() < 20'000);

  drive.forget();
  begin();
  done();
  drive.stop();
  pass(1ms);
  CHECK(done() == Words{"stopped"});
}

TEST_CASE_METHOD(DriveFixture,
                 "A run that was slowed down continues to its end when the emergency stop has settled") {
  begin();
  run(RunKind::Move, 20'000);
  turn(1'000);
  press(true);
  press(false);
  drive.slow_down();
  turn();
  drive.go_on();
  CHECK_FALSE(engine.moving());
  pass(6ms);
  inputs.serve();
  drive.go_on();
  turn();
  CHECK(engine.position() == 20'000);
  CHECK(done() == Words{"ready", "over"});
}

TEST_CASE_METHOD(DriveFixture,
                 "A halted run ends with the fault that halted it, even if a contact has come") {
  begin();
  done();
  run(RunKind::Seek, -20'000);
  turn(1'000);
  contact = true;
  cause = AxisFault{HomingResult::WrongSwitch, "the wrong switch", false};
  engine.halt_soon();
  turn();
  CHECK(done() == Words{"fault: the wrong switch"});
  CHECK(engine.position() == -1'000);
}

TEST_CASE_METHOD(DriveFixture,
                 "A pass that the limit switch's edge halts waits for the contact, and can be continued") {
  begin();
  done();
  run(RunKind::Seek, -2'000);
  turn(1'000);
  limit.set(true, clock.now());
  inputs.serve();
  turn();
  CHECK(engine.position() == -1'000);
  CHECK(done().empty());
  limit.set(false, clock.now());
  pass(6ms);
  inputs.serve();
  drive.end_run();
  drive.run_on();
  turn();
  CHECK(engine.position() == -2'000);
  CHECK(done() == Words{"over"});
}

TEST_CASE_METHOD(DriveFixture, "A contact that has come by the end of a pass is handled instead of the end") {
  begin();
  done();
  run(RunKind::Seek, -500);
  contact = true;
  turn();
  CHECK(done().empty());
}

TEST_CASE_METHOD(DriveFixture, "An inhibited motor does not turn and is reported as blocked") {
  engine.inhibit();
  drive.begin([this] { did.emplace_back("ready"); });
  CHECK(done().empty());
  pass(1ms);
  CHECK(done() == Words{"blocked"});
  CHECK_FALSE(enable.level);

  engine.enable();
  begin();
  run(RunKind::Move, 1'000);
  turn(100);
  engine.inhibit();
  turn();
  CHECK(done() == Words{"ready", "blocked"});
  CHECK(engine.position() == 100);
}

TEST_CASE_METHOD(DriveFixture,
                 "A line that cannot be set is a fault that names it, and line_refused() stays true") {
  begin();
  done();
  step.refuses = true;
  CHECK_FALSE(drive.line_refused());
  run(RunKind::Move, 1'000);
  turn();
  CHECK(done() == Words{"fault: the kernel refuses to set the step line, line 17 of gpiochip0, or the "
                        "direction line, line 27 of gpiochip0"});
  CHECK(drive.line_refused());

  DriveFixture other;
  other.enable.refuses = true;
  other.begin();
  CHECK(other.done() ==
        Words{"fault: the kernel refuses to set the motor's enable line, line 22 of gpiochip0"});
  CHECK(other.drive.line_refused());
}

TEST_CASE_METHOD(
    DriveFixture,
    "A halt makes no further step and forgets the position, and a new motion waits for the run's end") {
  position.become_known();
  begin();
  done();
  run(RunKind::Move, 20'000);
  turn(1'000);
  drive.halt();
  CHECK_FALSE(position.known());
  begin();
  CHECK(done().empty());
  turn();
  CHECK(done() == Words{"ready"});
  CHECK(engine.position() == 1'000);
}

TEST_CASE("The plate approaches a position from below if the screw has play") {
  DriveFixture fixture(drive_config(Nanometers{50'000}));  // 40 steps
  fixture.position.become_known();
  fixture.begin();
  fixture.approach.begin(Microsteps{1'000}, kRunSpeed, [&fixture] { fixture.did.emplace_back("there"); });
  fixture.turn();
  CHECK(fixture.done() == Words{"ready", "there"});
  CHECK(fixture.position.by_steps().plate() == Microsteps{1'000});

  fixture.approach.begin(Microsteps{500}, kRunSpeed, [&fixture] { fixture.did.emplace_back("there"); });
  fixture.turn();
  CHECK(fixture.engine.position() == 460);
  CHECK(fixture.done().empty());
  fixture.turn();
  CHECK(fixture.done() == Words{"there"});
  CHECK(fixture.position.by_steps().plate() == Microsteps{500});
  CHECK(fixture.position.by_steps().play == Microsteps{0});
}
