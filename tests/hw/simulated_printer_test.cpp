#include "hw/simulated_printer.hpp"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "hw/png_file.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/temporary_folder.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

constexpr Duration kFrame{16'666'667};

Mask mask_of_grey(std::uint8_t grey) {
  Mask mask(Pixels{8}, Pixels{6});
  for (std::int32_t y = 0; y < 6; ++y) {
    for (std::uint8_t& pixel : mask.row(y))
      pixel = grey;
  }
  return mask;
}

SimulatedPrinterConfig small_display() {
  SimulatedPrinterConfig config;
  config.display.width = Pixels{8};
  config.display.height = Pixels{6};
  return config;
}

// A printer on its own clock, with the results of its last calls.
struct Bench {
  explicit Bench(const SimulatedPrinterConfig& config = small_display()) : printer(clock, config) {}

  void run() {
    while (clock.run_next()) {
    }
  }
  void pass(Duration time) {
    bool over = false;
    const auto timer = clock.call_after(time, [&over] { over = true; });
    while (!over)
      clock.run_next();
  }
  [[nodiscard]] Duration now() const { return clock.now().time_since_epoch(); }

  void start_show(const Mask& mask) {
    answered = false;
    printer.display().show(mask, [this](std::optional<TimePoint> at) { answered = true, presented = at; });
  }
  void start_black() {
    answered = false;
    printer.display().black([this](std::optional<TimePoint> at) { answered = true, presented = at; });
  }
  void start_power_on() {
    reply.reset();
    printer.projector().power_on([this](ProjectorReply r) { reply = r; });
  }
  void start_light_on() {
    reply.reset();
    printer.projector().light_on(1s,
                                 {.sent = [](TimePoint) {}, .done = [this](ProjectorReply r) { reply = r; }});
  }
  void power_on() {
    start_power_on();
    run();
    REQUIRE(reply == ProjectorReply::Ok);
  }
  void light_on() {
    start_light_on();
    run();
    REQUIRE(reply == ProjectorReply::Ok);
  }

  VirtualClock clock;
  SimulatedPrinter printer;
  bool answered = false;
  std::optional<TimePoint> presented;
  std::optional<ProjectorReply> reply;
};

}  // namespace

TEST_CASE("A new printer is dark and black and still") {
  Bench bench;
  CHECK_FALSE(bench.printer.light_is_on());
  CHECK(bench.printer.screen_is_black());
  CHECK(bench.printer.masks_shown() == 0);
  CHECK_FALSE(bench.printer.z_axis().moving());
  CHECK(bench.printer.display().width() == Pixels{8});
  CHECK(bench.printer.display().height() == Pixels{6});
}

TEST_CASE("A mask is on the screen at the next refresh and not before") {
  Bench bench;
  bench.start_show(mask_of_grey(200));
  CHECK(bench.printer.screen_is_black());
  CHECK_FALSE(bench.answered);
  bench.run();
  CHECK(bench.answered);
  CHECK(bench.presented == TimePoint{kFrame});
  CHECK(bench.clock.now() == TimePoint{kFrame});
  CHECK_FALSE(bench.printer.screen_is_black());
  CHECK(bench.printer.masks_shown() == 1);
}

TEST_CASE("A mask requested at a refresh is on the screen at the next one") {
  Bench bench;
  bench.pass(3 * kFrame);
  bench.start_show(mask_of_grey(200));
  bench.run();
  CHECK(bench.presented == TimePoint{4 * kFrame});
  bench.pass(1ns);
  bench.start_show(mask_of_grey(100));
  bench.run();
  CHECK(bench.presented == TimePoint{5 * kFrame});
  bench.pass(kFrame - 1ns);
  bench.start_black();
  bench.run();
  CHECK(bench.presented == TimePoint{6 * kFrame});
  CHECK(bench.printer.screen_is_black());
}

TEST_CASE("Black at once drops a mask that waits for the next refresh") {
  Bench bench;
  bench.start_show(mask_of_grey(200));
  bench.printer.display().black_now();
  bench.run();
  CHECK_FALSE(bench.answered);
  CHECK(bench.printer.screen_is_black());
  bench.start_show(mask_of_grey(200));
  bench.run();
  CHECK_FALSE(bench.printer.screen_is_black());
  bench.printer.display().black_now();
  CHECK(bench.printer.screen_is_black());
}

TEST_CASE("A lost display answers that it is lost, and is black") {
  SimulatedPrinterConfig config = small_display();
  config.display.lost_after_frames = 2;
  Bench bench(config);
  for (int i = 0; i < 2; ++i) {
    bench.start_show(mask_of_grey(200));
    bench.run();
    CHECK(bench.presented.has_value());
  }
  bench.start_show(mask_of_grey(200));
  CHECK_FALSE(bench.answered);  // from the event loop, as always
  bench.run();
  CHECK(bench.answered);
  CHECK_FALSE(bench.presented.has_value());
  CHECK(bench.printer.screen_is_black());
}

TEST_CASE("A display is unplugged once, reports that, and comes back") {
  SimulatedPrinterConfig config = small_display();
  config.display.lost_after_frames = 1;
  config.display.back_after = 60s;
  Bench bench(config);
  std::vector<MachineEvent> reported;
  bench.printer.on_event([&](const MachineEvent& event) { reported.push_back(event); });
  bench.start_show(mask_of_grey(200));
  bench.run();
  CHECK(bench.printer.why_not_ready().empty());
  bench.start_show(mask_of_grey(200));
  while (reported.empty())
    REQUIRE(bench.clock.run_next());
  CHECK(reported[0].kind == MachineEvent::Kind::Interlock);
  CHECK(bench.printer.why_not_ready() == "the display is unplugged");
  CHECK(bench.printer.screen_is_black());
  bench.run();
  REQUIRE(reported.size() == 2);
  CHECK(reported[1].kind == MachineEvent::Kind::Recovery);
  CHECK(bench.printer.why_not_ready().empty());
  bench.start_show(mask_of_grey(200));
  bench.run();
  CHECK(bench.presented.has_value());
  CHECK(reported.size() == 2);
}

TEST_CASE("A display unplugged between a mask and its refresh never showed it") {
  Bench bench(small_display());
  bench.start_show(mask_of_grey(200));
  bench.printer.unplug_display();
  bench.run();
  CHECK(bench.answered);
  CHECK_FALSE(bench.presented.has_value());
}

TEST_CASE("The lid is opened when the light has been on for long enough, and closed again") {
  SimulatedPrinterConfig config;
  config.lid_opened_after_light = 3s;
  config.lid_open_for = 4s;
  VirtualClock clock;
  SimulatedPrinter printer(clock, config);
  std::vector<std::pair<MachineEvent::Kind, TimePoint>> reported;
  printer.on_event([&](const MachineEvent& event) { reported.emplace_back(event.kind, clock.now()); });
  printer.projector().power_on([](ProjectorReply) {});
  while (clock.run_next()) {
  }
  TimePoint lit{};
  for (int i = 0; i < 2; ++i) {
    printer.projector().light_on(
        1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply) { lit = clock.now(); }});
    const auto off = clock.call_after(2s + config.projector.reply, [&] { printer.projector().light_off(); });
    while (clock.run_next()) {
    }
  }
  // Two seconds of the first light, one of the second.
  REQUIRE(reported.size() == 2);
  CHECK(reported[0] == std::pair{MachineEvent::Kind::Interlock, lit + 1s});
  CHECK(reported[1] == std::pair{MachineEvent::Kind::Recovery, lit + 5s});
}

TEST_CASE("A job's masks are saved as PNG files in its own folder") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.path() / "masks";
  Bench bench(config);
  const auto job = bench.printer.begin_job("cube");
  REQUIRE(job.has_value());
  CHECK(*job == folder.path() / "masks" / "cube");
  CHECK(std::filesystem::is_directory(*job));
  for (const std::uint8_t grey : {std::uint8_t{200}, std::uint8_t{100}}) {
    bench.start_show(mask_of_grey(grey));
    bench.run();
  }
  bench.start_black();
  bench.run();
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(*job))
    files.push_back(entry.path().filename());
  CHECK(files.size() == 2);
  const auto content = [](const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(file), {});
  };
  CHECK(content(*job / "0001.png") == encode_png(mask_of_grey(200)));
  CHECK(content(*job / "0002.png") == encode_png(mask_of_grey(100)));
}

TEST_CASE("Each job counts its masks from one") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.path();
  Bench bench(config);
  for (const char* name : {"first", "second"}) {
    (void)bench.printer.begin_job(name);
    CHECK(bench.printer.masks_shown() == 0);
    bench.start_show(mask_of_grey(1));
    bench.run();
    CHECK(bench.printer.masks_shown() == 1);
    CHECK(std::filesystem::exists(folder.path() / name / "0001.png"));
  }
}

TEST_CASE("A folder for masks that cannot be made is an error") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.write("a file", "");
  Bench bench(config);
  CHECK_THROWS_AS(bench.printer.begin_job("cube"), std::filesystem::filesystem_error);
}

TEST_CASE("Without a folder for masks none are saved") {
  Bench bench;
  CHECK_FALSE(bench.printer.begin_job("cube").has_value());
  bench.start_show(mask_of_grey(1));
  bench.run();
  CHECK(bench.printer.masks_shown() == 1);
}

TEST_CASE("The lamp is warm after power on and its light stays off") {
  Bench bench;
  bench.start_power_on();
  CHECK_FALSE(bench.reply.has_value());
  bench.run();
  CHECK(bench.reply == ProjectorReply::Ok);
  CHECK(bench.now() == 5s + 20ms);
  CHECK_FALSE(bench.printer.light_is_on());
}

TEST_CASE("Power on of a warm lamp does not wait again") {
  Bench bench;
  bench.power_on();
  const Duration before = bench.now();
  bench.power_on();
  CHECK(bench.now() - before == 20ms);
}

TEST_CASE("The light goes on when the projector has answered and off at once") {
  Bench bench;
  bench.power_on();
  const Duration before = bench.now();
  bench.start_light_on();
  CHECK_FALSE(bench.printer.light_is_on());
  bench.run();
  CHECK(bench.reply == ProjectorReply::Ok);
  CHECK(bench.printer.light_is_on());
  CHECK(bench.now() - before == 20ms);
  bench.printer.projector().light_off();
  CHECK_FALSE(bench.printer.light_is_on());
  bench.printer.projector().light_off();
  CHECK_FALSE(bench.printer.light_is_on());
}

TEST_CASE("Without power or before the lamp is warm the light is refused") {
  Bench cold;
  cold.start_light_on();
  CHECK_FALSE(cold.reply.has_value());
  cold.run();
  CHECK(cold.reply == ProjectorReply::Refused);
  CHECK_FALSE(cold.printer.light_is_on());
  Bench off_again;
  off_again.power_on();
  off_again.printer.projector().power_off();
  off_again.start_light_on();
  off_again.run();
  CHECK(off_again.reply == ProjectorReply::Refused);
  CHECK_FALSE(off_again.printer.light_is_on());
}

TEST_CASE("Light off drops a light on that waits for its answer") {
  Bench bench;
  bench.power_on();
  bench.start_light_on();
  bench.printer.projector().light_off();
  bench.run();
  CHECK_FALSE(bench.reply.has_value());
  CHECK_FALSE(bench.printer.light_is_on());
}

TEST_CASE("Power off puts the light out and the lamp must warm up again") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.printer.projector().power_off();
  CHECK_FALSE(bench.printer.light_is_on());
  const Duration before = bench.now();
  bench.power_on();
  CHECK(bench.now() - before == 5s + 20ms);
}

TEST_CASE("A projector that falls silent is given up after its timeout and turns no light on") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 2;
  Bench bench(config);
  bench.power_on();
  bench.light_on();
  bench.printer.projector().light_off();
  const Duration before = bench.now();
  bench.start_light_on();
  bench.run();
  CHECK(bench.reply == ProjectorReply::NoAnswer);
  CHECK(bench.now() - before == 2s);
  CHECK_FALSE(bench.printer.light_is_on());
}

TEST_CASE("A projector that never answers does not get warm") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 0;
  Bench bench(config);
  bench.start_power_on();
  bench.run();
  CHECK(bench.reply == ProjectorReply::NoAnswer);
  CHECK(bench.now() == 2s);
  bench.start_light_on();
  bench.run();
  CHECK(bench.reply != ProjectorReply::Ok);
  CHECK_FALSE(bench.printer.light_is_on());
}

TEST_CASE("A machine made safe is dark and black and still whatever it was doing") {
  Bench bench;
  bench.power_on();
  bench.light_on();
  bench.start_show(mask_of_grey(200));
  bench.run();
  bench.printer.z_axis().home([](HomingResult) {});
  bench.pass(1s);
  bench.start_show(mask_of_grey(100));
  REQUIRE(bench.printer.light_is_on());
  REQUIRE_FALSE(bench.printer.screen_is_black());
  REQUIRE(bench.printer.z_axis().moving());
  make_safe(bench.printer);
  CHECK_FALSE(bench.printer.light_is_on());
  CHECK(bench.printer.screen_is_black());
  CHECK_FALSE(bench.printer.z_axis().moving());
  bench.run();
  CHECK_FALSE(bench.printer.light_is_on());
  CHECK(bench.printer.screen_is_black());
}

TEST_CASE("the simulated projector says whether it is on, and what its last failure was") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 2;
  Bench bench(config);
  std::optional<ProjectorStatus> status;
  const auto ask = [&] {
    bench.printer.projector().ask_status([&](const ProjectorStatus& s) { status = s; });
    bench.run();
    REQUIRE(status);
  };
  ask();
  CHECK(status->powered == false);
  bench.power_on();
  ask();
  CHECK(status->reply == ProjectorReply::NoAnswer);
  CHECK(status->problem == "the projector does not answer");
  CHECK_FALSE(status->powered);
}

TEST_CASE("A printer may be destroyed while everything is under way") {
  VirtualClock clock;
  {
    SimulatedPrinter printer(clock, small_display());
    printer.z_axis().home([](HomingResult) { FAIL("homed"); });
    printer.display().show(mask_of_grey(1), [](std::optional<TimePoint>) { FAIL("shown"); });
    printer.projector().power_on([](ProjectorReply) { FAIL("powered"); });
  }
  CHECK(clock.idle());
  CHECK_FALSE(clock.run_next());
}
