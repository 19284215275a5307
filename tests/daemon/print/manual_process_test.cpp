#include "daemon/print/manual_process.hpp"

#include "core/image/test_pattern.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

namespace {

constexpr MillimetersPerSecond kSpeed{5};

class ManualProcessFixture {
 public:
  explicit ManualProcessFixture(const SimulatedPrinterConfig& config = {}) : machine(clock, config) {
    machine.on_event([this](const MachineEvent& event) { process.fail(event.what); });
  }

  // Runs the clock until the condition holds. Fails the test if anything moves while the light is on.
  bool run_until(const std::function<bool()>& holds) {
    for (int steps = 0; steps < 100'000; ++steps) {
      const bool both = machine.light_is_on() && machine.z_axis().moving();
      REQUIRE_FALSE(both);
      if (holds()) return true;
      if (!clock.run_next()) return holds();
    }
    return false;
  }
  bool run_to(ManualState state) {
    return run_until([&] { return process.state() == state; });
  }
  bool run_to_end() { return run_to(ManualState::Idle); }
  // Runs the clock for this time, even if no event happens at its end.
  void run_for(Duration time) {
    bool over = false;
    const auto end = clock.call_after(time, [&over] { over = true; });
    run_until([&over] { return over; });
  }
  void home() {
    process.home(kSpeed);
    REQUIRE(run_to_end());
    REQUIRE(process.problem().empty());
  }
  void show(Duration time) {
    process.show(draw_test_pattern(TestPattern::White, machine.display().width(), machine.display().height(),
                                   Micrometers{50}),
                 "white", time);
  }

  VirtualClock clock;
  SimulatedPrinter machine;
  int changes = 0;
  ManualProcess process{machine, clock, [this] { ++changes; }};
};

}  // namespace

TEST_CASE("Manual homing and a manual move end by themselves, at the requested height") {
  ManualProcessFixture fixture;
  fixture.home();
  CHECK(fixture.machine.z_axis().height() == Nanometers{0});
  fixture.process.move_to(Nanometers{7'000'000}, kSpeed);
  CHECK(fixture.process.state() == ManualState::Moving);
  CHECK(fixture.run_to_end());
  CHECK(fixture.machine.z_axis().height() == Nanometers{7'000'000});
  CHECK(fixture.process.operations() == 2);
  CHECK(fixture.process.problem().empty());
}

TEST_CASE("A stopped manual move slows down, and its position is still known") {
  ManualProcessFixture fixture;
  fixture.home();
  fixture.process.move_to(Nanometers{50'000'000}, kSpeed);
  fixture.run_for(2s);
  fixture.process.stop();
  CHECK(fixture.process.state() == ManualState::Braking);
  CHECK(fixture.run_to_end());
  CHECK_FALSE(fixture.machine.z_axis().moving());
  CHECK(fixture.machine.z_axis().height() < Nanometers{15'000'000});
  CHECK(fixture.process.problem() == "stopped");
}

TEST_CASE("Manual homing that finds no switch or is stopped reports it and leaves the motor still") {
  SimulatedPrinterConfig config;
  config.axis.limit_switch = SimulatedAxisConfig::Switch::StuckOpen;
  ManualProcessFixture fixture(config);
  fixture.process.home(kSpeed);
  CHECK(fixture.run_to_end());
  CHECK(fixture.process.problem().starts_with("homing failed: "));
  fixture.process.home(kSpeed);
  fixture.run_for(1s);
  fixture.process.stop();
  CHECK(fixture.run_to_end());
  CHECK(fixture.process.problem() == "stopped");
  CHECK_FALSE(fixture.machine.z_axis().moving());
}

TEST_CASE("A manual nudge begins at an unknown position and reports why it did not go all the way") {
  SimulatedPrinterConfig config;
  config.axis.start_height = Nanometers{1'000'000};
  ManualProcessFixture fixture(config);
  fixture.process.nudge(Nanometers{2'000'000}, MillimetersPerSecond{1});
  CHECK(fixture.process.state() == ManualState::Moving);
  CHECK(fixture.run_to_end());
  CHECK(fixture.process.problem().empty());
  for (int times = 0; times < 2; ++times) {
    fixture.process.nudge(Nanometers{-2'000'000}, MillimetersPerSecond{1});
    CHECK(fixture.run_to_end());
  }
  CHECK(fixture.process.problem() == "the plate did not go all the way: the limit switch is reached");
  CHECK_FALSE(fixture.machine.z_axis().height());
  fixture.process.nudge(Nanometers{2'000'000}, MillimetersPerSecond{1});
  fixture.run_for(500ms);
  fixture.process.stop();
  CHECK(fixture.process.state() == ManualState::Braking);
  CHECK(fixture.run_to_end());
  CHECK(fixture.process.problem() == "stopped");
}

TEST_CASE(
    "Manual homing reports how far the switch has shifted since the homing before, until the next "
    "operation") {
  ManualProcessFixture fixture;
  fixture.home();
  CHECK_FALSE(fixture.process.homing_shift());
  fixture.home();
  CHECK(fixture.process.homing_shift() == Nanometers{0});
  fixture.process.ask_status();
  CHECK_FALSE(fixture.process.homing_shift());
}

TEST_CASE("Manual light warms the projector up, is on for the requested time, and is confirmed off") {
  ManualProcessFixture fixture;
  fixture.process.light_on(3s);
  CHECK(fixture.process.state() == ManualState::WarmingUp);
  CHECK(fixture.run_to(ManualState::Lit));
  const TimePoint on = fixture.clock.now();
  CHECK(fixture.process.light_may_be_on());
  CHECK(fixture.run_until([&] { return fixture.machine.light_is_on(); }));
  CHECK(fixture.run_until([&] { return !fixture.machine.light_is_on(); }));
  // The commands for light on and light off each take the time of a reply.
  CHECK(fixture.clock.now() - on <= 3s + 2 * SimulatedProjectorConfig{}.reply);
  CHECK(fixture.run_to_end());
  CHECK_FALSE(fixture.process.light_may_be_on());
  CHECK(fixture.process.problem().empty());
}

TEST_CASE("Manual light goes off at once when it is stopped or the lid is opened, in any state") {
  for (const ManualState state : {ManualState::WarmingUp, ManualState::Igniting, ManualState::Lit}) {
    CAPTURE(name_of(state));
    for (const bool lid : {false, true}) {
      ManualProcessFixture fixture;
      fixture.process.light_on(30s);
      REQUIRE(fixture.run_to(state));
      if (state == ManualState::Lit) fixture.run_for(1s);
      lid ? fixture.machine.open_lid() : fixture.process.stop();
      CHECK(fixture.process.state() == ManualState::Extinguishing);
      fixture.run_for(2 * SimulatedProjectorConfig{}.reply);
      CHECK_FALSE(fixture.machine.light_is_on());
      CHECK(fixture.run_to_end());
      CHECK(fixture.process.problem() == (lid ? "the lid was opened" : "stopped"));
    }
  }
}

TEST_CASE("A projector that never confirms that its light is off is reported after a timeout") {
  SimulatedPrinterConfig config;
  config.projector.silent_after_commands = 1;
  ManualProcessFixture fixture(config);
  fixture.process.light_on(3s);
  CHECK(fixture.run_to_end());
  CHECK(fixture.process.problem() ==
        "light on: the projector does not answer; the light may be on: the projector has not confirmed that "
        "its light is off");
}

TEST_CASE("A picture is shown for its time, also during a motion, and disappears when the lid is opened") {
  ManualProcessFixture fixture;
  fixture.show(10s);
  fixture.run_for(1s);
  CHECK_FALSE(fixture.machine.screen_is_black());
  CHECK(fixture.process.picture() == "white");
  fixture.home();
  fixture.run_until([&] { return fixture.process.picture().empty(); });
  CHECK(fixture.machine.screen_is_black());
  fixture.show(10s);
  fixture.run_for(1s);
  fixture.machine.open_lid();
  CHECK(fixture.process.picture().empty());
  CHECK(fixture.machine.screen_is_black());
}

TEST_CASE("A projector that was powered on manually is powered off on request, or when it is not used") {
  const auto powered = [](ManualProcessFixture& fixture) {
    fixture.process.ask_status();
    REQUIRE(fixture.run_to_end());
    REQUIRE(fixture.process.projector());
    return fixture.process.projector()->powered == true;
  };
  ManualProcessFixture fixture;
  fixture.process.power_on();
  REQUIRE(fixture.run_to_end());
  CHECK(powered(fixture));
  fixture.process.power_off();
  REQUIRE(fixture.run_to_end());
  CHECK_FALSE(powered(fixture));
  fixture.process.power_on();
  REQUIRE(fixture.run_to_end());
  fixture.run_for(9min);
  CHECK(powered(fixture));
  fixture.run_for(5min);
  fixture.show(7min);
  fixture.run_for(6min);
  CHECK_FALSE(fixture.process.picture().empty());
  CHECK(powered(fixture));
  fixture.run_for(20min);
  CHECK_FALSE(powered(fixture));
  // After give_way() the print is responsible for the projector's power.
  fixture.process.power_on();
  REQUIRE(fixture.run_to_end());
  fixture.process.give_way();
  fixture.run_for(11min);
  CHECK(powered(fixture));
}

TEST_CASE("Destroying the manual process during an operation leaves the machine safe") {
  VirtualClock clock;
  SimulatedPrinter machine(clock, {});
  {
    ManualProcess process(machine, clock, [] {});
    process.light_on(30s);
    while (!machine.light_is_on())
      REQUIRE(clock.run_next());
  }
  while (!clock.idle())
    (void)clock.run_next();
  CHECK_FALSE(machine.light_is_on());
}
