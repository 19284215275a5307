#include "daemon/app/printer_service.hpp"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/catch.hpp"
#include "tests/daemon/jobs/printer_fixture.hpp"
#include "tests/daemon/print/late_machine.hpp"

namespace fs = std::filesystem;

namespace {

constexpr const char* kInvalidModel = "no model";

// A printer in a temporary folder, with a machine that the test can manipulate. Its clock skips all waiting.
class PrinterServiceFixture {
 public:
  PrinterServiceFixture() { config.wait_for_plate_cleared = false; }

  void start() {
    machine = std::make_unique<SimulatedPrinter>(clock, config.simulated);
    start_with(*machine);
  }
  void start_with(Machine& whole) {
    service = std::make_unique<PrinterService>(config, loop, clock, whole, log, supervisor);
    service->start();
  }
  void stop() {
    service.reset();
    machine.reset();
  }

  // Puts a model 1 mm high, or a file with this text, into incoming/.
  void drop(const std::string& name, const char* text = nullptr) {
    const fs::path staging = folder.write(name, text == nullptr ? "" : text);
    if (text == nullptr) models::write_binary_stl(staging, models::box({0, 0, 0}, {5, 5, 1}));
    fs::rename(staging, config.spool_folder / "incoming" / name);
  }
  [[nodiscard]] nlohmann::json report_of(const std::string& job) const {
    std::ifstream file(config.spool_folder / "done" / (job + ".report.json"));
    return nlohmann::json::parse(file);
  }
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(config.spool_folder / name); }

  // Runs until the file exists in the spool. Calls `look` after every step. May be called only once, because
  // an event loop cannot run again.
  void run_until(const std::string& file, const std::function<void()>& look) {
    CHECK(testing::run_loop_until(loop, [&] {
      look();
      (void)clock.run_next();
      return has(file);
    }));
  }
  // Runs until the invalid model `bad`, dropped after the others, is refused: the others have had their turn
  // then.
  void run_until_refused(const std::string& bad, const std::function<void()>& look) {
    run_until("failed/" + bad, look);
  }

  testing::TemporaryFolder folder;
  PrinterConfig config = testing::simulated_config(folder.path());
  EventLoop loop;
  VirtualClock clock;
  Log log{loop};
  Supervisor supervisor{loop};
  std::unique_ptr<SimulatedPrinter> machine;
  std::unique_ptr<PrinterService> service;
};

}  // namespace

TEST_CASE("A report counts the late steps of its own print only") {
  PrinterServiceFixture fixture;
  fixture.machine = std::make_unique<SimulatedPrinter>(fixture.clock, fixture.config.simulated);
  LateMachine machine(*fixture.machine);
  machine.axis.late.count = 5;
  fixture.start_with(machine);
  fixture.drop("one.stl");
  bool moved = false;
  fixture.run_until("done/two.stl", [&] {
    if (moved || !machine.axis.moving()) return;
    moved = true;
    machine.axis.late.count = 12;
    fixture.drop("two.stl");
  });
  CHECK(fixture.report_of("one")["late_steps"] == 7);
  CHECK(fixture.report_of("two")["late_steps"] == 0);
  fixture.stop();
}

TEST_CASE("A notice of the machine is logged as a warning, and the print goes on") {
  PrinterServiceFixture fixture;
  fixture.machine = std::make_unique<SimulatedPrinter>(fixture.clock, fixture.config.simulated);
  LateMachine machine(*fixture.machine);
  fixture.start_with(machine);
  fixture.drop("one.stl");
  std::ostringstream log;
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(log)));
  bool reported = false;
  fixture.run_until("done/one.stl", [&] {
    if (reported || !machine.axis.moving()) return;
    reported = true;
    machine.report({.kind = MachineEvent::Kind::Notice, .what = "0.125 mm are made good"});
  });
  CHECK(reported);
  CHECK(log.str().find("[warning] 0.125 mm are made good") != std::string::npos);
  fixture.stop();
}

TEST_CASE("After an emergency stop during homing is released, no motor starts and the next job waits") {
  PrinterServiceFixture fixture;
  fixture.start();
  fixture.drop("one.stl");
  bool stopped = false, moved = false, filed = false;
  fixture.run_until_refused("bad.stl", [&] {
    const bool moving = fixture.machine->z_axis().moving();
    if (stopped) moved = moved || moving;
    if (!filed && (filed = fixture.has("failed/one.stl"))) fixture.drop("bad.stl", kInvalidModel);
    if (stopped || !moving) return;
    stopped = true;
    fixture.machine->press_emergency_stop();
    fixture.drop("two.stl");
  });
  CHECK(stopped);
  CHECK_FALSE(moved);
  CHECK(fixture.has("failed/one.stl"));
  CHECK(fixture.has("incoming/two.stl"));
}

TEST_CASE("An emergency stop pressed while nothing prints holds the queue after its release") {
  PrinterServiceFixture fixture;
  fixture.start();
  fixture.machine->press_emergency_stop();
  bool moved = false;
  SECTION("in this process") {}
  SECTION("in the next process") {
    fixture.stop();
    fixture.start();
  }
  fixture.drop("one.stl");
  fixture.drop("bad.stl", kInvalidModel);
  fixture.run_until_refused("bad.stl", [&] { moved = moved || fixture.machine->z_axis().moving(); });
  CHECK_FALSE(moved);
  CHECK(fixture.has("incoming/one.stl"));
}

namespace {

// Returns the report of a print during which something keeps the loop busy once, with the light on or off.
nlohmann::json report_with_busy_loop(Duration busy, bool lit) {
  PrinterServiceFixture fixture;
  fixture.start();
  fixture.drop("one.stl");
  EventLoop::SourcePtr timer;
  bool began = false;
  fixture.run_until("done/one.stl", [&] {
    began = began || fixture.machine->z_axis().moving();
    if (timer || !began || fixture.machine->light_is_on() != lit) return;
    // The machine's clock stands still meanwhile, because it advances only while the loop is idle.
    timer = fixture.loop.at(std::chrono::steady_clock::now(), "a busy test", [&fixture, busy] {
      while (fixture.loop.turn().busy < busy) {
      }
    });
  });
  CHECK(timer);
  auto report = fixture.report_of("one");
  fixture.stop();
  return report;
}

}  // namespace

TEST_CASE("The report has the loop's longest call while the light was on") {
  CHECK(report_with_busy_loop(25ms, true)["loop_busy_ms_worst_lit"] >= 25);
}

TEST_CASE("The report ignores calls that keep the loop busy in the dark") {
  // A tenth of the time is longer than anything that the loop does with the light on.
  CHECK(report_with_busy_loop(500ms, false)["loop_busy_ms_worst_lit"] < 50);
}

TEST_CASE("A hold of the queue is written to the disk after the light is off, not while it is on") {
  PrinterServiceFixture fixture;
  fixture.start();
  fixture.drop("one.stl");
  // A thread writes the hold as soon as the light is off, which may be before the event loop goes on.
  const auto held_in_the_light = [&] {
    return fixture.machine->light_is_on() && fixture.has("../spool.state/queue-held");
  };
  bool stopped = false;
  fixture.run_until("failed/one.stl", [&] {
    CHECK_FALSE(held_in_the_light());
    if (stopped || !fixture.machine->light_is_on()) return;
    stopped = true;
    fixture.machine->press_emergency_stop();
    CHECK_FALSE(held_in_the_light());
  });
  CHECK(stopped);
  CHECK(fixture.has("../spool.state/queue-held"));
  fixture.stop();
}
