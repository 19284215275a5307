#include "hw/simulated_printer.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "hw/png_file.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"
#include "tests/hw/masks.hpp"
#include "tests/hw/virtual_time_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace {

constexpr Duration kFrame{16'666'667};

Mask mask_of_grey(std::uint8_t grey) {
  return testing::mask_of(8, 6, grey);
}

SimulatedPrinterConfig small_display() {
  SimulatedPrinterConfig config;
  config.display.width = Pixels{8};
  config.display.height = Pixels{6};
  return config;
}

// A printer on its own clock, with the results of its last calls.
struct SimulatedPrinterFixture : testing::VirtualTimeFixture {
  explicit SimulatedPrinterFixture(const SimulatedPrinterConfig& config = small_display())
      : printer(clock, config) {}

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

  SimulatedPrinter printer;
  bool answered = false;
  std::optional<TimePoint> presented;
  std::optional<ProjectorReply> reply;
};

}  // namespace

TEST_CASE_METHOD(SimulatedPrinterFixture, "A new printer is dark and black and still") {
  CHECK_FALSE(printer.light_is_on());
  CHECK(printer.screen_is_black());
  CHECK(printer.masks_shown() == 0);
  CHECK_FALSE(printer.z_axis().moving());
  CHECK(printer.display().width() == Pixels{8});
  CHECK(printer.display().height() == Pixels{6});
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "A mask is on the screen at the next refresh and not before") {
  start_show(mask_of_grey(200));
  CHECK(printer.screen_is_black());
  CHECK_FALSE(answered);
  run();
  CHECK(answered);
  CHECK(presented == TimePoint{kFrame});
  CHECK(clock.now() == TimePoint{kFrame});
  CHECK_FALSE(printer.screen_is_black());
  CHECK(printer.masks_shown() == 1);
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "A mask requested at a refresh is on the screen at the next one") {
  pass(3 * kFrame);
  start_show(mask_of_grey(200));
  run();
  CHECK(presented == TimePoint{4 * kFrame});
  pass(1ns);
  start_show(mask_of_grey(100));
  run();
  CHECK(presented == TimePoint{5 * kFrame});
  pass(kFrame - 1ns);
  start_black();
  run();
  CHECK(presented == TimePoint{6 * kFrame});
  CHECK(printer.screen_is_black());
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "Black at once drops a mask that waits for the next refresh") {
  start_show(mask_of_grey(200));
  printer.display().black_now();
  run();
  CHECK_FALSE(answered);
  CHECK(printer.screen_is_black());
  start_show(mask_of_grey(200));
  run();
  CHECK_FALSE(printer.screen_is_black());
  printer.display().black_now();
  CHECK(printer.screen_is_black());
}

TEST_CASE("A lost display answers that it is lost, and is black") {
  SimulatedPrinterConfig config = small_display();
  config.display.lost_after_frames = 2;
  SimulatedPrinterFixture fixture(config);
  for (int i = 0; i < 2; ++i) {
    fixture.start_show(mask_of_grey(200));
    fixture.run();
    CHECK(fixture.presented.has_value());
  }
  fixture.start_show(mask_of_grey(200));
  CHECK_FALSE(fixture.answered);  // from the event loop, as always
  fixture.run();
  CHECK(fixture.answered);
  CHECK_FALSE(fixture.presented.has_value());
  CHECK(fixture.printer.screen_is_black());
}

TEST_CASE("A display is unplugged once, reports that, and comes back") {
  SimulatedPrinterConfig config = small_display();
  config.display.lost_after_frames = 1;
  config.display.back_after = 60s;
  SimulatedPrinterFixture fixture(config);
  std::vector<MachineEvent> reported;
  fixture.printer.on_event([&](const MachineEvent& event) { reported.push_back(event); });
  fixture.start_show(mask_of_grey(200));
  fixture.run();
  CHECK(fixture.printer.why_not_ready().empty());
  fixture.start_show(mask_of_grey(200));
  while (reported.empty())
    REQUIRE(fixture.clock.run_next());
  CHECK(reported[0].kind == MachineEvent::Kind::Interlock);
  CHECK(fixture.printer.why_not_ready() == "the display is unplugged");
  CHECK(fixture.printer.screen_is_black());
  fixture.run();
  REQUIRE(reported.size() == 2);
  CHECK(reported[1].kind == MachineEvent::Kind::Recovery);
  CHECK(fixture.printer.why_not_ready().empty());
  fixture.start_show(mask_of_grey(200));
  fixture.run();
  CHECK(fixture.presented.has_value());
  CHECK(reported.size() == 2);
}

TEST_CASE("A display unplugged between a mask and its refresh never showed it") {
  SimulatedPrinterFixture fixture(small_display());
  fixture.start_show(mask_of_grey(200));
  fixture.printer.unplug_display();
  fixture.run();
  CHECK(fixture.answered);
  CHECK_FALSE(fixture.presented.has_value());
}

TEST_CASE("The lid is opened when the light has been on for long enough, and closed again") {
  SimulatedPrinterConfig config;
  config.lid_opened_after_light = 3s;
  config.lid_open_for = 4s;
  SimulatedPrinterFixture fixture(config);
  SimulatedPrinter& printer = fixture.printer;
  std::vector<std::pair<MachineEvent::Kind, TimePoint>> reported;
  printer.on_event(
      [&](const MachineEvent& event) { reported.emplace_back(event.kind, fixture.clock.now()); });
  fixture.power_on();
  TimePoint lit{};
  for (int i = 0; i < 2; ++i) {
    printer.projector().light_on(
        1s, {.sent = [](TimePoint) {}, .done = [&](ProjectorReply) { lit = fixture.clock.now(); }});
    const auto off =
        fixture.clock.call_after(2s + config.projector.reply, [&] { printer.projector().light_off(); });
    fixture.run();
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
  SimulatedPrinterFixture fixture(config);
  const auto job = fixture.printer.begin_job("cube");
  REQUIRE(job.has_value());
  CHECK(*job == folder.path() / "masks" / "cube");
  CHECK(std::filesystem::is_directory(*job));
  for (const std::uint8_t grey : {std::uint8_t{200}, std::uint8_t{100}}) {
    fixture.start_show(mask_of_grey(grey));
    fixture.run();
  }
  fixture.start_black();
  fixture.run();
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

TEST_CASE("The times at which masks and light of a job come and go are recorded beside its folder") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.path();
  SimulatedPrinterFixture fixture(config);
  fixture.power_on();
  (void)fixture.printer.begin_job("cube");
  fixture.start_show(mask_of_grey(255));
  fixture.run();
  const TimePoint shown = *fixture.presented;
  fixture.light_on();
  const TimePoint lit = fixture.clock.now();
  fixture.start_show(mask_of_grey(1));
  fixture.run();
  const TimePoint changed = *fixture.presented;
  fixture.printer.projector().light_off();
  fixture.printer.display().black_now();
  std::ifstream file(folder.path() / "cube.shown.tsv");
  const std::string record{std::istreambuf_iterator(file), {}};
  const auto line = [](TimePoint at, const std::string& event) {
    return std::to_string(at.time_since_epoch().count()) + "\t" + event + "\n";
  };
  CHECK(record == line(shown, "0001.png") + line(lit, "light on") + line(changed, "0002.png") +
                      line(fixture.clock.now(), "light off") + line(fixture.clock.now(), "black"));
}

TEST_CASE("Each job counts its masks from one") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.path();
  SimulatedPrinterFixture fixture(config);
  for (const char* name : {"first", "second"}) {
    (void)fixture.printer.begin_job(name);
    CHECK(fixture.printer.masks_shown() == 0);
    fixture.start_show(mask_of_grey(1));
    fixture.run();
    CHECK(fixture.printer.masks_shown() == 1);
    CHECK(std::filesystem::exists(folder.path() / name / "0001.png"));
  }
}

TEST_CASE("A folder for masks that cannot be made is an error") {
  const testing::TemporaryFolder folder;
  SimulatedPrinterConfig config = small_display();
  config.display.masks = folder.write("a file", "");
  SimulatedPrinterFixture fixture(config);
  CHECK_THROWS_AS(fixture.printer.begin_job("cube"), std::filesystem::filesystem_error);
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "Without a folder for masks none are saved") {
  CHECK_FALSE(printer.begin_job("cube").has_value());
  start_show(mask_of_grey(1));
  run();
  CHECK(printer.masks_shown() == 1);
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "The lamp is warm after power on and its light stays off") {
  start_power_on();
  CHECK_FALSE(reply.has_value());
  run();
  CHECK(reply == ProjectorReply::Ok);
  CHECK(now() == 5s + 20ms);
  CHECK_FALSE(printer.light_is_on());
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "Power on of a warm lamp does not wait again") {
  power_on();
  const Duration before = now();
  power_on();
  CHECK(now() - before == 20ms);
}

TEST_CASE_METHOD(SimulatedPrinterFixture,
                 "The light goes on when the projector has answered and off at once") {
  power_on();
  const Duration before = now();
  start_light_on();
  CHECK_FALSE(printer.light_is_on());
  run();
  CHECK(reply == ProjectorReply::Ok);
  CHECK(printer.light_is_on());
  CHECK(now() - before == 20ms);
  printer.projector().light_off();
  CHECK_FALSE(printer.light_is_on());
  printer.projector().light_off();
  CHECK_FALSE(printer.light_is_on());
}

TEST_CASE("Without power or before the lamp is warm the light is refused") {
  SimulatedPrinterFixture cold;
  cold.start_light_on();
  CHECK_FALSE(cold.reply.has_value());
  cold.run();
  CHECK(cold.reply == ProjectorReply::Refused);
  CHECK_FALSE(cold.printer.light_is_on());
  SimulatedPrinterFixture off_again;
  off_again.power_on();
  off_again.printer.projector().power_off();
  off_again.start_light_on();
  off_again.run();
  CHECK(off_again.reply == ProjectorReply::Refused);
  CHECK_FALSE(off_again.printer.light_is_on());
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "Light off drops a light on that waits for its answer") {
  power_on();
  start_light_on();
  printer.projector().light_off();
  run();
  CHECK_FALSE(reply.has_value());
  CHECK_FALSE(printer.light_is_on());
}

TEST_CASE_METHOD(SimulatedPrinterFixture, "Power off puts the light out and the lamp must warm up again") {
  power_on();
  light_on();
  printer.projector().power_off();
  CHECK_FALSE(printer.light_is_on());
  const Duration before = now();
  power_on();
  CHECK(now() - before == 5s + 20ms);
}

TEST_CASE("A projector that falls silent is given up after its timeout and turns no light on") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 2;
  SimulatedPrinterFixture fixture(config);
  fixture.power_on();
  fixture.light_on();
  fixture.printer.projector().light_off();
  const Duration before = fixture.now();
  fixture.start_light_on();
  fixture.run();
  CHECK(fixture.reply == ProjectorReply::NoAnswer);
  CHECK(fixture.now() - before == 2s);
  CHECK_FALSE(fixture.printer.light_is_on());
}

TEST_CASE("A projector that never answers does not get warm") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 0;
  SimulatedPrinterFixture fixture(config);
  fixture.start_power_on();
  fixture.run();
  CHECK(fixture.reply == ProjectorReply::NoAnswer);
  CHECK(fixture.now() == 2s);
  fixture.start_light_on();
  fixture.run();
  CHECK(fixture.reply != ProjectorReply::Ok);
  CHECK_FALSE(fixture.printer.light_is_on());
}

TEST_CASE_METHOD(SimulatedPrinterFixture,
                 "A machine made safe is dark and black and still whatever it was doing") {
  power_on();
  light_on();
  start_show(mask_of_grey(200));
  run();
  printer.z_axis().home([](HomingResult) {});
  pass(1s);
  start_show(mask_of_grey(100));
  REQUIRE(printer.light_is_on());
  REQUIRE_FALSE(printer.screen_is_black());
  REQUIRE(printer.z_axis().moving());
  make_safe(printer);
  CHECK_FALSE(printer.light_is_on());
  CHECK(printer.screen_is_black());
  CHECK_FALSE(printer.z_axis().moving());
  run();
  CHECK_FALSE(printer.light_is_on());
  CHECK(printer.screen_is_black());
}

TEST_CASE("the simulated projector says whether it is on, and what its last failure was") {
  SimulatedPrinterConfig config = small_display();
  config.projector.silent_after_commands = 2;
  SimulatedPrinterFixture fixture(config);
  std::optional<ProjectorStatus> status;
  const auto ask = [&] {
    fixture.printer.projector().ask_status([&](const ProjectorStatus& s) { status = s; });
    fixture.run();
    REQUIRE(status);
  };
  ask();
  CHECK(status->powered == false);
  fixture.power_on();
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
