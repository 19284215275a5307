#include "daemon/print/manual_process.hpp"

#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "core/image/test_pattern.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

constexpr MillimetersPerSecond kSpeed{5};

class Bench {
 public:
  explicit Bench(const SimulatedPrinterConfig& config = {}) : machine(clock, config) {
    machine.on_event([this](const MachineEvent& event) { process.fail(event.what); });
  }

  // The clock goes on until this is so. Motion in the light is wrong at any time.
  bool run_until(const std::function<bool()>& so) {
    for (int steps = 0; steps < 100'000; ++steps) {
      const bool both = machine.light_is_on() && machine.z_axis().moving();
      REQUIRE_FALSE(both);
      if (so()) return true;
      if (!clock.run_next()) return so();
    }
    return false;
  }
  bool run_to(ManualState state) {
    return run_until([&] { return process.state() == state; });
  }
  bool run_to_end() { return run_to(ManualState::Idle); }
  // Up to a time, also when nothing happens then.
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

TEST_CASE("Home and move by hand end by themselves, at the height that was asked for") {
  Bench bench;
  bench.home();
  CHECK(bench.machine.z_axis().height() == Nanometers{0});
  bench.process.move_to(Nanometers{7'000'000}, kSpeed);
  CHECK(bench.process.state() == ManualState::Moving);
  CHECK(bench.run_to_end());
  CHECK(bench.machine.z_axis().height() == Nanometers{7'000'000});
  CHECK(bench.process.operations() == 2);
  CHECK(bench.process.problem().empty());
}

TEST_CASE("A move by hand that is stopped slows down, and its position is still known") {
  Bench bench;
  bench.home();
  bench.process.move_to(Nanometers{50'000'000}, kSpeed);
  bench.run_for(2s);
  bench.process.stop();
  CHECK(bench.process.state() == ManualState::Braking);
  CHECK(bench.run_to_end());
  CHECK_FALSE(bench.machine.z_axis().moving());
  CHECK(bench.machine.z_axis().height() < Nanometers{15'000'000});
  CHECK(bench.process.problem() == "stopped");
}

TEST_CASE("Homing by hand that finds no switch, or is stopped, says so, and the motor is still") {
  SimulatedPrinterConfig config;
  config.axis.limit_switch = SimulatedAxisConfig::Switch::StuckOpen;
  Bench bench(config);
  bench.process.home(kSpeed);
  CHECK(bench.run_to_end());
  CHECK(bench.process.problem().starts_with("homing failed: "));
  bench.process.home(kSpeed);
  bench.run_for(1s);
  bench.process.stop();
  CHECK(bench.run_to_end());
  CHECK(bench.process.problem() == "stopped");
  CHECK_FALSE(bench.machine.z_axis().moving());
}

TEST_CASE(
    "A nudge by hand goes from nobody knows where, and says where it ended when that was before its end") {
  SimulatedPrinterConfig config;
  config.axis.start_height = Nanometers{1'000'000};
  Bench bench(config);
  bench.process.nudge(Nanometers{2'000'000}, MillimetersPerSecond{1});
  CHECK(bench.process.state() == ManualState::Moving);
  CHECK(bench.run_to_end());
  CHECK(bench.process.problem().empty());
  for (int times = 0; times < 2; ++times) {
    bench.process.nudge(Nanometers{-2'000'000}, MillimetersPerSecond{1});
    CHECK(bench.run_to_end());
  }
  CHECK(bench.process.problem() == "the plate did not go all the way: the limit switch is reached");
  CHECK_FALSE(bench.machine.z_axis().height());
  bench.process.nudge(Nanometers{2'000'000}, MillimetersPerSecond{1});
  bench.run_for(500ms);
  bench.process.stop();
  CHECK(bench.process.state() == ManualState::Braking);
  CHECK(bench.run_to_end());
  CHECK(bench.process.problem() == "stopped");
}

TEST_CASE("Homing by hand tells how far from before the switch was found, until the next operation") {
  Bench bench;
  bench.home();
  CHECK_FALSE(bench.process.homing_shift());
  bench.home();
  CHECK(bench.process.homing_shift() == Nanometers{0});
  bench.process.ask_status();
  CHECK_FALSE(bench.process.homing_shift());
}

TEST_CASE("Light by hand warms the projector up, shines as long as was asked, and is confirmed off") {
  Bench bench;
  bench.process.light_on(3s);
  CHECK(bench.process.state() == ManualState::WarmingUp);
  CHECK(bench.run_to(ManualState::Lit));
  const TimePoint on = bench.clock.now();
  CHECK(bench.process.light_may_be_on());
  CHECK(bench.run_until([&] { return bench.machine.light_is_on(); }));
  CHECK(bench.run_until([&] { return !bench.machine.light_is_on(); }));
  // Its commands take a reply's time each.
  CHECK(bench.clock.now() - on <= 3s + 2 * SimulatedProjectorConfig{}.reply);
  CHECK(bench.run_to_end());
  CHECK_FALSE(bench.process.light_may_be_on());
  CHECK(bench.process.problem().empty());
}

TEST_CASE("Light by hand goes off at once when it is stopped or the lid is opened, wherever it was") {
  for (const ManualState state : {ManualState::WarmingUp, ManualState::Igniting, ManualState::Lit}) {
    CAPTURE(name_of(state));
    for (const bool lid : {false, true}) {
      Bench bench;
      bench.process.light_on(30s);
      REQUIRE(bench.run_to(state));
      if (state == ManualState::Lit) bench.run_for(1s);
      lid ? bench.machine.open_lid() : bench.process.stop();
      CHECK(bench.process.state() == ManualState::Extinguishing);
      bench.run_for(2 * SimulatedProjectorConfig{}.reply);
      CHECK_FALSE(bench.machine.light_is_on());
      CHECK(bench.run_to_end());
      CHECK(bench.process.problem() == (lid ? "the lid was opened" : "stopped"));
    }
  }
}

TEST_CASE("A projector that never confirms that its light is off is told, after a while") {
  SimulatedPrinterConfig config;
  config.projector.silent_after_commands = 1;
  Bench bench(config);
  bench.process.light_on(3s);
  CHECK(bench.run_to_end());
  CHECK(bench.process.problem() ==
        "light on: the projector does not answer; the light may be on: the projector has not confirmed that "
        "its light is off");
}

TEST_CASE("A picture is shown for its time, also beside a motion, and is gone when something happens") {
  Bench bench;
  bench.show(10s);
  bench.run_for(1s);
  CHECK_FALSE(bench.machine.screen_is_black());
  CHECK(bench.process.picture() == "white");
  bench.home();
  bench.run_until([&] { return bench.process.picture().empty(); });
  CHECK(bench.machine.screen_is_black());
  bench.show(10s);
  bench.run_for(1s);
  bench.machine.open_lid();
  CHECK(bench.process.picture().empty());
  CHECK(bench.machine.screen_is_black());
}

TEST_CASE("A projector that was powered on by hand is powered off when nobody uses it, or asked to") {
  const auto powered = [](Bench& bench) {
    bench.process.ask_status();
    REQUIRE(bench.run_to_end());
    REQUIRE(bench.process.projector());
    return bench.process.projector()->powered == true;
  };
  Bench bench;
  bench.process.power_on();
  REQUIRE(bench.run_to_end());
  CHECK(powered(bench));
  bench.process.power_off();
  REQUIRE(bench.run_to_end());
  CHECK_FALSE(powered(bench));
  bench.process.power_on();
  REQUIRE(bench.run_to_end());
  bench.run_for(9min);
  CHECK(powered(bench));
  bench.run_for(5min);
  bench.show(7min);
  bench.run_for(6min);
  CHECK_FALSE(bench.process.picture().empty());
  CHECK(powered(bench));
  bench.run_for(20min);
  CHECK_FALSE(powered(bench));
  // A print has taken over: it is the print's then.
  bench.process.power_on();
  REQUIRE(bench.run_to_end());
  bench.process.give_way();
  bench.run_for(11min);
  CHECK(powered(bench));
}

TEST_CASE("What is done by hand and not over when its process goes leaves the machine safe") {
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
