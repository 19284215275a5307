#include "daemon/app/printer_service.hpp"

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/config/printer_config.hpp"
#include "daemon/system/event_loop.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/print/late_machine.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
using contourd::testing::LateMachine;
namespace fs = std::filesystem;

namespace {

// A tetrahedron 1 mm high.
constexpr const char* kModel = R"(solid tetrahedron
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 5 0
vertex 5 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 5 0 0
vertex 0 0 1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 5 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 5 0 0
vertex 0 5 0
vertex 0 0 1
endloop
endfacet
endsolid tetrahedron
)";

constexpr const char* kNoModel = "no model";

// A printer in a folder of its own, whose machine a test can lay hands on. Its time goes on as fast as it
// can.
class Bench {
 public:
  Bench() {
    config = load_printer_config(fs::path(CONTOURD_CONFIG_DIR) / "simulated.json");
    config.spool_folder = folder.path() / "spool";
    config.control_socket = folder.path() / "control.sock";
    config.wait_for_plate_cleared = false;
    config.min_free_disk_bytes = 0;
    config.simulated.display.masks.reset();
    config.supports = SupportPolicy::Off;
  }

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

  void drop(const std::string& name, const char* text = kModel) {
    const fs::path staging = folder.write(name, text);
    fs::rename(staging, config.spool_folder / "incoming" / name);
  }
  [[nodiscard]] nlohmann::json report_of(const std::string& job) const {
    std::ifstream file(config.spool_folder / "done" / (job + ".report.json"));
    return nlohmann::json::parse(file);
  }
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(config.spool_folder / name); }

  // Runs until this file lies in the spool. `look` is called after every step. To be called once: an event
  // loop does not run again.
  void run_until(const std::string& file, const std::function<void()>& look) {
    bool there = false;
    const auto given_up =
        loop.at(std::chrono::steady_clock::now() + 20s, "the test", [this] { loop.stop(); });
    const auto steps = loop.when_idle("the test's clock", [&] {
      look();
      there = has(file);
      if (there) loop.stop();
      (void)clock.run_next();
      return !there;
    });
    loop.run();
    CHECK(there);
  }
  // Until a file that is no model, dropped behind the others, is refused: by then these have had their turn.
  void run_until_refused(const std::string& bad, const std::function<void()>& look) {
    run_until("failed/" + bad, look);
  }

  testing::TemporaryFolder folder;
  PrinterConfig config;
  EventLoop loop;
  VirtualClock clock;
  Log log{loop};
  Supervisor supervisor{loop};
  std::unique_ptr<SimulatedPrinter> machine;
  std::unique_ptr<PrinterService> service;
};

}  // namespace

TEST_CASE("The report has the steps that came late in its print, and no others") {
  Bench bench;
  bench.machine = std::make_unique<SimulatedPrinter>(bench.clock, bench.config.simulated);
  LateMachine machine(*bench.machine);
  machine.axis.late.count = 5;
  bench.start_with(machine);
  bench.drop("one.stl");
  bool moved = false;
  bench.run_until("done/two.stl", [&] {
    if (moved || !machine.axis.moving()) return;
    moved = true;
    machine.axis.late.count = 12;
    bench.drop("two.stl");
  });
  CHECK(bench.report_of("one")["late_steps"] == 7);
  CHECK(bench.report_of("two")["late_steps"] == 0);
  bench.stop();
}

TEST_CASE("What an owner should know of a machine is a warning in the log, and the print goes on") {
  Bench bench;
  bench.machine = std::make_unique<SimulatedPrinter>(bench.clock, bench.config.simulated);
  LateMachine machine(*bench.machine);
  bench.start_with(machine);
  bench.drop("one.stl");
  std::ostringstream log;
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(log)));
  bool told = false;
  bench.run_until("done/one.stl", [&] {
    if (told || !machine.axis.moving()) return;
    told = true;
    machine.report({.kind = MachineEvent::Kind::Notice, .what = "0.125 mm are made good"});
  });
  CHECK(told);
  CHECK(log.str().find("[warning] 0.125 mm are made good") != std::string::npos);
  bench.stop();
}

TEST_CASE("An emergency stop in homing, let go again, starts no motor: the next job waits for the owner") {
  Bench bench;
  bench.start();
  bench.drop("one.stl");
  bool stopped = false, moved = false, filed = false;
  bench.run_until_refused("bad.stl", [&] {
    const bool moving = bench.machine->z_axis().moving();
    if (stopped) moved = moved || moving;
    if (!filed && (filed = bench.has("failed/one.stl"))) bench.drop("bad.stl", kNoModel);
    if (stopped || !moving) return;
    stopped = true;
    bench.machine->press_emergency_stop();
    bench.drop("two.stl");
  });
  CHECK(stopped);
  CHECK_FALSE(moved);
  CHECK(bench.has("failed/one.stl"));
  CHECK(bench.has("incoming/two.stl"));
}

TEST_CASE("An emergency stop pressed while nothing is printed keeps jobs waiting when it is let go") {
  Bench bench;
  bench.start();
  bench.machine->press_emergency_stop();
  bool moved = false;
  // After a restart, too.
  SECTION("in this process") {}
  SECTION("and in the next") {
    bench.stop();
    bench.start();
  }
  bench.drop("one.stl");
  bench.drop("bad.stl", kNoModel);
  bench.run_until_refused("bad.stl", [&] { moved = moved || bench.machine->z_axis().moving(); });
  CHECK_FALSE(moved);
  CHECK(bench.has("incoming/one.stl"));
}

namespace {

// The report of a print beside which something keeps the loop busy once, with the light on or off.
nlohmann::json report_with_busy_loop(Duration busy, bool lit) {
  Bench bench;
  bench.start();
  bench.drop("one.stl");
  EventLoop::SourcePtr timer;
  bool began = false;
  bench.run_until("done/one.stl", [&] {
    began = began || bench.machine->z_axis().moving();
    if (timer || !began || bench.machine->light_is_on() != lit) return;
    // The clock stands still meanwhile: it runs in the idle loop only.
    timer = bench.loop.at(std::chrono::steady_clock::now(), "a busy test", [&bench, busy] {
      while (bench.loop.turn().busy < busy) {
      }
    });
  });
  CHECK(timer);
  auto report = bench.report_of("one");
  bench.stop();
  return report;
}

}  // namespace

TEST_CASE("The report has the loop's longest call while the light was on") {
  CHECK(report_with_busy_loop(25ms, true)["loop_busy_ms_worst_lit"] >= 25);
}

TEST_CASE("What keeps the loop busy in the dark is not in the report") {
  // A tenth of it is more than anything that the loop does with the light on.
  CHECK(report_with_busy_loop(500ms, false)["loop_busy_ms_worst_lit"] < 50);
}

TEST_CASE("That the queue is held is written to the disk when the light is off, not beside it") {
  Bench bench;
  bench.start();
  bench.drop("one.stl");
  bool stopped = false;
  bench.run_until("failed/one.stl", [&] {
    if (stopped || !bench.machine->light_is_on()) return;
    stopped = true;
    bench.machine->press_emergency_stop();
    CHECK_FALSE(bench.has("../spool.state/queue-held"));
  });
  CHECK(stopped);
  CHECK(bench.has("../spool.state/queue-held"));
  bench.stop();
}
