#include "daemon/printer_service.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>

#include "daemon/config/printer_config.hpp"
#include "daemon/event_loop.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;
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
  }

  void start() {
    machine = std::make_unique<SimulatedPrinter>(clock, config.simulated);
    service = std::make_unique<PrinterService>(config, loop, clock, *machine, log, supervisor);
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
  [[nodiscard]] bool has(const std::string& name) const { return fs::exists(config.spool_folder / name); }

  // Runs until a file that is no model, dropped behind the others, is refused: by then these have had their
  // turn. `look` is called after every step. To be called once: an event loop does not run again.
  void run_until_refused(const std::string& bad, const std::function<void()>& look) {
    bool refused = false;
    const auto given_up = loop.at(std::chrono::steady_clock::now() + 20s, [this] { loop.stop(); });
    const auto steps = loop.when_idle([&] {
      look();
      refused = has("failed/" + bad);
      if (refused) loop.stop();
      (void)clock.run_next();
      return !refused;
    });
    loop.run();
    CHECK(refused);
  }

  testing::TemporaryFolder folder;
  PrinterConfig config;
  EventLoop loop;
  VirtualClock clock;
  Log log;
  Supervisor supervisor{loop};
  std::unique_ptr<SimulatedPrinter> machine;
  std::unique_ptr<PrinterService> service;
};

}  // namespace

TEST_CASE("An emergency stop in homing, let go again, starts no motor: the next job waits for the owner") {
  Bench bench;
  bench.start();
  bench.drop("one.stl");
  bool stopped = false, moved = false;
  bench.run_until_refused("bad.stl", [&] {
    const bool moving = bench.machine->z_axis().moving();
    if (stopped) moved = moved || moving;
    if (stopped || !moving) return;
    stopped = true;
    bench.machine->press_emergency_stop();
    bench.drop("two.stl");
    bench.drop("bad.stl", kNoModel);
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
