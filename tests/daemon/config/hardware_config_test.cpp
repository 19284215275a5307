#include <fmt/format.h>

#include <filesystem>

#include "daemon/config/printer_config.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// The shipped profile of a real machine in a folder with a resin and projector tables.
class RealPrinterFixture {
 public:
  RealPrinterFixture() : printer(shipped("raspberry-pi-4.json")) {
    for (const char* line : {"step", "direction", "enable", "limit_switch"})
      printer["z_axis"][line].erase("chip");
    folder_.write_json("resins/standard.json", shipped("resins/standard.json"));
    folder_.write_json("projectors/optoma.json", shipped("projectors/optoma.json"));
    folder_.write_json("projectors/acer.json", shipped("projectors/acer.json"));
  }
  [[nodiscard]] json& at(const std::string& pointer) { return printer[json::json_pointer(pointer)]; }
  void remove(const std::string& section, const std::string& key) { printer[section].erase(key); }
  void write(const std::filesystem::path& name, const json& value) { folder_.write_json(name, value); }
  [[nodiscard]] PrinterConfig load() const {
    return load_printer_config(folder_.write_json("printer.json", printer));
  }
  [[nodiscard]] Complaints complaints() const {
    return complaints_of([&] { (void)load(); });
  }
  [[nodiscard]] std::filesystem::path path() const { return folder_.path(); }

  json printer;

 private:
  ConfigFolder folder_;
};

json encoder_with(const std::string& more, int counts_per_mm = 800) {
  return json::parse(fmt::format(R"({{"a": {{"line": 7}}, "b": {{"line": 8}}, "counts_per_mm": {}{}}})",
                                 counts_per_mm, more));
}

Complaints real_complaints_with(const std::string& pointer, const json& value) {
  RealPrinterFixture printer;
  printer.at(pointer) = value;
  return printer.complaints();
}

TEST_CASE("the shipped profiles of real machines load, with the pins that docs/printer-setup.md shows") {
  const auto [model, chip] =
      GENERATE(std::pair{3, "pinctrl-bcm2835"}, std::pair{4, "pinctrl-bcm2711"}, std::pair{5, "pinctrl-rp1"});
  const PrinterConfig config = load_printer_config(std::filesystem::path(CONTOURD_CONFIG_DIR) /
                                                   fmt::format("raspberry-pi-{}.json", model));
  REQUIRE(config.real);
  const GpioAxisConfig& axis = config.real->axis;
  CHECK(axis.step.line == "17");
  CHECK_FALSE(axis.step.active_low);
  CHECK(axis.direction.line == "27");
  REQUIRE(axis.enable);
  for (const GpioLineConfig& line : {axis.step, axis.direction, *axis.enable, axis.limit_switch.line})
    CHECK(line.chip == chip);
  CHECK(axis.enable->line == "22");
  CHECK(axis.enable->active_low);
  CHECK(axis.limit_switch.line.line == "23");
  CHECK(axis.limit_switch.bias == LineBias::PullUp);
  CHECK(axis.limit_switch.contact == Contact::NormallyClosed);
  CHECK(config.warnings.empty());
  CHECK(config.real->display.connector == "HDMI-A-1");
  REQUIRE(config.real->projector);
  CHECK(std::get<SerialProjectorConfig>(*config.real->projector).table.name == "Optoma");
  CHECK(config.pace == Pace::Realtime);
}

TEST_CASE(
    "keys missing in a real machine's profile get the schema's defaults, which equal those of the C++ "
    "types") {
  RealPrinterFixture printer;
  printer.printer["z_axis"]["step"] = {{"line", 17}};
  printer.printer["z_axis"]["limit_switch"] = {{"line", 23}};
  printer.printer["display"].erase("card");
  const GpioAxisConfig axis = printer.load().real->axis;
  const GpioAxisConfig defaults;
  CHECK(axis.step.chip == GpioLineConfig{}.chip);
  CHECK_FALSE(axis.step.active_low);
  CHECK(axis.limit_switch.bias == LineBias::AsIs);
  CHECK(axis.limit_switch.debounce == defaults.limit_switch.debounce);
  CHECK(axis.limit_switch.contact == Contact::NormallyOpen);
  CHECK(axis.pulse_width == defaults.pulse_width);
  CHECK(axis.direction_setup == defaults.direction_setup);
  CHECK(axis.realtime_priority == defaults.realtime_priority);
  CHECK(axis.backlash == defaults.backlash);
  CHECK(axis.switch_height == defaults.switch_height);
  CHECK_FALSE(axis.homes_upwards);
  CHECK_FALSE(axis.jerk_mm_s3);
  CHECK_FALSE(axis.second_switch);
  CHECK_FALSE(axis.encoder);
  CHECK_FALSE(axis.emergency_stop);
  CHECK_FALSE(axis.lid);
  const DrmDisplayConfig display = printer.load().real->display;
  CHECK(display.format == DrmDisplayConfig::Format::Xrgb8888);
  CHECK(display.buffers == 2);
  CHECK_FALSE(display.card);
  CHECK_FALSE(printer.load().real->light);
}

TEST_CASE("every key of a real machine arrives with its unit") {
  RealPrinterFixture printer;
  printer.printer["z_axis"].update(json::parse(R"({
    "travel_mm": 150.5, "microsteps_per_mm": 400.5, "homing_speed_mm_s": 3.5, "travel_speed_mm_s": 6.5,
    "top_speed_mm_s": 7.5, "acceleration_mm_s2": 30.5, "jerk_mm_s3": 500.5, "backlash_um": 12.5,
    "switch_height_mm": 151.25, "homes_upwards": true, "pulse_width_us": 2.5, "direction_setup_us": 6.5,
    "second_switch": {"chip": "/dev/gpiochip1", "line": "END2", "bias": "pull_down", "debounce_ms": 1.5},
    "emergency_stop": {"line": 5, "bias": "off", "contact": "normally_closed"}, "lid": {"line": 6, "active_low": true},
    "encoder": {"a": {"line": 7}, "b": {"line": 8, "active_low": true}, "bias": "pull_up", "counts_per_mm": 200.5,
                "reversed": true, "tolerance_um": 12.5, "policy": "correct", "most_correction_um": 100.5,
                "most_correction_sum_um": 200.5, "index": {"line": 9}, "index_every_mm": 4.5},
    "realtime_priority": 30})"));
  printer.printer["display"].update(
      json::parse(R"({"card": "vc4", "format": "rgb565", "buffers": 3, "refresh_hz": 59.5, "width_px": 1280,
                      "height_px": 800, "legacy_kms": true, "ignore_edid_size": true})"));
  printer.printer["projector"].update(json::parse(R"({"light": {"line": 24}, "warm_up_s": 31.5})"));
  const PrinterConfig config = printer.load();
  const GpioAxisConfig& axis = config.real->axis;
  CHECK(axis.travel == Nanometers{150'500'000});
  CHECK(axis.microsteps_per_mm == 400.5);
  CHECK(axis.homing_speed == MillimetersPerSecond{3.5});
  CHECK(axis.top_speed == MillimetersPerSecond{7.5});
  CHECK(axis.acceleration == MillimetersPerSecondSquared{30.5});
  CHECK(axis.jerk_mm_s3 == 500.5);
  CHECK(axis.backlash == Nanometers{12'500});
  CHECK(axis.switch_height == Nanometers{151'250'000});
  CHECK(axis.homes_upwards);
  CHECK(axis.pulse_width == Duration{2'500});
  CHECK(axis.direction_setup == Duration{6'500});
  REQUIRE(axis.second_switch);
  CHECK(axis.second_switch->line.chip == "/dev/gpiochip1");
  CHECK(axis.second_switch->line.line == "END2");
  CHECK(axis.second_switch->bias == LineBias::PullDown);
  CHECK(axis.second_switch->debounce == Duration{1'500'000});
  CHECK(axis.emergency_stop->bias == LineBias::Off);
  CHECK(axis.emergency_stop->contact == Contact::NormallyClosed);
  CHECK_FALSE(axis.emergency_stop->line.active_low);
  CHECK(axis.lid->contact == Contact::NormallyOpen);
  CHECK(axis.lid->line.active_low);
  REQUIRE(axis.encoder);
  CHECK(axis.encoder->a.line == "7");
  CHECK(axis.encoder->b.active_low);
  CHECK(axis.encoder->bias == LineBias::PullUp);
  CHECK(axis.encoder->counts_per_mm == 200.5);
  CHECK(axis.encoder->reversed);
  CHECK(axis.encoder->tolerance == Nanometers{12'500});
  CHECK(axis.encoder->policy == EncoderConfig::Policy::Correct);
  CHECK(axis.encoder->most_correction == Nanometers{100'500});
  CHECK(axis.encoder->most_correction_sum == Nanometers{200'500});
  REQUIRE(axis.encoder->index);
  CHECK(axis.encoder->index->line == "9");
  CHECK(axis.encoder->index_every == Nanometers{4'500'000});
  CHECK(axis.realtime_priority == 30);
  const DrmDisplayConfig& display = config.real->display;
  CHECK(display.card == "vc4");
  CHECK(display.format == DrmDisplayConfig::Format::Rgb565);
  CHECK(display.buffers == 3);
  CHECK(display.refresh_hz == 59.5);
  CHECK(display.width == Pixels{1280});
  CHECK(display.height == Pixels{800});
  CHECK(display.legacy);
  CHECK(display.ignore_edid_size);
  const auto& projector = std::get<SerialProjectorConfig>(*config.real->projector);
  CHECK(projector.port == "/dev/ttyUSB0");
  CHECK(projector.table.warm_up == std::chrono::milliseconds{31'500});
  CHECK(config.real->light->line == "24");
  CHECK(config.real->warm_up == std::chrono::milliseconds{31'500});
}

TEST_CASE(
    "a force line arrives with its units, its defaults equal those of the C++ types, and it needs a line") {
  RealPrinterFixture printer;
  CHECK_FALSE(printer.load().force);
  CHECK_FALSE(printer.load().real->axis.force);
  printer.printer["z_axis"]["force"] = {{"line", 12}};
  const PrinterConfig least = printer.load();
  REQUIRE(least.real->axis.force);
  CHECK(least.real->axis.force->input.debounce == GpioInputConfig{}.debounce);
  CHECK(least.real->axis.force->contact_from == ForceConfig{}.contact_from);
  REQUIRE(least.force);
  CHECK(least.force->contact_from == ForceConfig{}.contact_from);
  CHECK_FALSE(least.force->resistance_fails);
  CHECK(least.force->pauses_without_peel);
  CHECK(least.force->least_peel_area_mm2 == 20);

  printer.printer["z_axis"]["force"] =
      json::parse(R"({"line": 12, "contact": "normally_closed", "bias": "pull_up", "active_low": true,
                      "debounce_ms": 2.5, "contact_from_mm": 1.25, "resistance": "fail",
                      "least_peel_area_mm2": 7.5, "no_peel": "tell"})");
  const PrinterConfig config = printer.load();
  CHECK(config.warnings.empty());
  const ForceConfig& force = config.real->axis.force.value();
  CHECK(force.input.line.line == "12");
  CHECK(force.input.contact == Contact::NormallyClosed);
  CHECK(force.input.bias == LineBias::PullUp);
  CHECK(force.input.debounce == std::chrono::microseconds{2'500});
  CHECK(force.contact_from == Nanometers{1'250'000});
  CHECK(config.force->resistance_fails);
  CHECK_FALSE(config.force->pauses_without_peel);
  CHECK(config.force->least_peel_area_mm2 == 7.5);

  printer.printer["z_axis"]["force"] = {{"contact_from_mm", 45}};
  printer.printer["z_axis"]["travel_mm"] = 40;
  const Complaints complaints = printer.complaints();
  REQUIRE(complaints.size() == 2);
  CHECK(complaints[1].starts_with("/z_axis/force/line: this key is missing, and \"hardware\" is \"real\": "));
  CHECK(complaints[0] ==
        "/z_axis/force/contact_from_mm: 45 is not less than z_axis/travel_mm, 40 mm: no force would ever be "
        "resistance");
}

TEST_CASE("the warm-up is the longer one of the printer's and its projector table's") {
  RealPrinterFixture printer;
  printer.printer["projector"].update(json::parse(R"({"light": {"line": 24}, "warm_up_s": 1.5})"));
  CHECK(printer.load().real->warm_up == std::chrono::seconds{30});
  for (const char* key : {"port", "table"})
    printer.remove("projector", key);
  CHECK(printer.load().real->warm_up == std::chrono::milliseconds{1500});
}

TEST_CASE(
    "a real machine's profile also serves the simulated one, and the keys that it has are checked as "
    "strictly") {
  RealPrinterFixture printer;
  printer.printer["hardware"] = "simulated";
  CHECK_FALSE(printer.load().real);
  for (const char* key : {"step", "direction", "limit_switch", "top_speed_mm_s"})
    printer.remove("z_axis", key);
  printer.remove("projector", "port");
  printer.remove("projector", "table");
  CHECK(printer.complaints().empty());
  printer.printer["projector"]["light"] = {{"line", 22}};
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/enable: line \"22\" of \"gpiochip0\" is already used for projector/light"});
}

TEST_CASE("all missing required keys of a real machine are reported with their descriptions") {
  RealPrinterFixture printer;
  for (const char* key : {"step", "direction", "limit_switch", "top_speed_mm_s"})
    printer.remove("z_axis", key);
  printer.remove("projector", "port");
  printer.remove("projector", "table");
  const Complaints complaints = printer.complaints();
  REQUIRE(complaints.size() == 5);
  CHECK(complaints[0].starts_with("/projector: nothing turns the light on and off: give a \"light\" line"));
  CHECK(complaints[1] ==
        "/z_axis/direction: this key is missing, and \"hardware\" is \"real\": Line of the motor driver's "
        "direction "
        "input, active while the plate rises. Required for a real machine");
  CHECK(complaints[2].starts_with("/z_axis/limit_switch: this key is missing"));
  CHECK(complaints[3].starts_with("/z_axis/step: this key is missing"));
  CHECK(complaints[4].starts_with("/z_axis/top_speed_mm_s: this key is missing"));
}

TEST_CASE("two functions on one line are found, however the line is written") {
  for (const auto& [chip, line] : std::vector<std::pair<std::string, json>>{
           {"gpiochip0", 17}, {"gpiochip0", "17"}, {"/dev/gpiochip0", 17}, {"gpiochip0", "017"}}) {
    CAPTURE(chip, line.dump());
    CHECK(real_complaints_with("/z_axis/lid", {{"chip", chip}, {"line", line}}) ==
          Complaints{"/z_axis/step: line \"17\" of \"gpiochip0\" is already used for z_axis/lid"});
  }
  CHECK(real_complaints_with("/z_axis/lid", {{"chip", "gpiochip1"}, {"line", 17}}).empty());
  // The chip's default counts.
  CHECK(real_complaints_with("/z_axis/emergency_stop", {{"line", 27}}).size() == 1);
  CHECK(real_complaints_with("/z_axis/encoder",
                             {{"a", {{"line", 5}}}, {"b", {{"line", 5}}}, {"counts_per_mm", 100}}) ==
        Complaints{"/z_axis/encoder/b: line \"5\" of \"gpiochip0\" is already used for z_axis/encoder/a"});
}

TEST_CASE("an invalid line is refused with its place") {
  CHECK(real_complaints_with("/z_axis/step/line", -1) ==
        Complaints{"/z_axis/step/line: -1 is less than the least allowed, 0"});
  CHECK(real_complaints_with("/z_axis/step/line", true) ==
        Complaints{"/z_axis/step/line: expected a text or a whole number, found true"});
  CHECK(real_complaints_with("/z_axis/step/line", "") ==
        Complaints{"/z_axis/step/line: it must not be empty"});
  CHECK(real_complaints_with("/z_axis/step/pin", 17) ==
        Complaints{"/z_axis/step/pin: there is no key \"pin\" here; did you mean \"line\"?"});
  CHECK(real_complaints_with("/z_axis/lid", json::object()).size() == 1);
  CHECK(real_complaints_with("/z_axis/limit_switch/bias", "up") ==
        Complaints{
            "/z_axis/limit_switch/bias: the text \"up\" is not one of \"as_is\", \"pull_up\", \"pull_down\", "
            "\"off\""});
}

TEST_CASE("no speed exceeds the top speed, not even the resin's, apart from those that only save time") {
  CHECK(real_complaints_with("/z_axis/travel_speed_mm_s", 5.5) ==
        Complaints{"/z_axis/travel_speed_mm_s: 5.5 is more than z_axis/top_speed_mm_s, 5 mm/s"});
  CHECK(real_complaints_with("/z_axis/homing_speed_mm_s", 6).size() == 1);
  RealPrinterFixture printer;
  json resin = shipped("resins/standard.json");
  resin["lift_speed_mm_s"] = 8;
  resin["slow_retract_speed_mm_s"] = 5.5;
  resin["second_lift_speed_mm_s"] = resin["retract_speed_mm_s"] = 9;
  printer.write("resins/standard.json", resin);
  CHECK(printer.complaints() ==
        Complaints{"/lift_speed_mm_s: 8 is more than the printer's top speed, 5 mm/s",
                   "/slow_retract_speed_mm_s: 5.5 is more than the printer's top speed, 5 mm/s"});
  // No plate comes down at this speed.
  resin["lift_speed_mm_s"] = 1;
  resin["slow_retract_mm"] = 0;
  printer.write("resins/standard.json", resin);
  CHECK(printer.complaints().empty());
}

TEST_CASE(
    "steps that come faster than a computer makes them, or than the motor driver sees them, are refused") {
  RealPrinterFixture printer;
  printer.at("/z_axis/top_speed_mm_s") = 25;  // times 800
  CHECK(printer.complaints().empty());
  printer.at("/z_axis/top_speed_mm_s") = 25.5;
  CHECK(
      printer.complaints() ==
      Complaints{
          "/z_axis/top_speed_mm_s: 25.5 mm/s at 800 microsteps per mm are 20400 steps a second; the limit is "
          "20000, that is 25 mm/s"});
  printer.at("/z_axis/top_speed_mm_s") = 10;
  printer.at("/z_axis/pulse_width_us") = 46.875;  // 8000 pulses and pauses are three quarters of a second
  CHECK(printer.complaints().empty());
  printer.at("/z_axis/pulse_width_us") = 100;
  CHECK(printer.complaints() ==
        Complaints{
            "/z_axis/top_speed_mm_s: 10 mm/s at 800 microsteps per mm are 8000 steps a second; the limit is "
            "3750 with this z_axis/pulse_width_us, that is 4.6875 mm/s"});
}

TEST_CASE("a switch at the top must be above the travel") {
  RealPrinterFixture printer;
  printer.at("/z_axis/homes_upwards") = true;
  CHECK(
      printer.complaints() ==
      Complaints{
          "/z_axis/switch_height_mm: 0 is less than z_axis/travel_mm, 160 mm, but the switch is at the top: "
          "the plate would run into it"});
  printer.at("/z_axis/switch_height_mm") = 160;
  CHECK(printer.complaints().empty());
}

TEST_CASE("a switch at the bottom must be near the height where the plate touches the film") {
  RealPrinterFixture printer;
  for (const double height : {-10.0, -0.5, 10.0}) {
    printer.at("/z_axis/switch_height_mm") = height;
    CHECK(printer.complaints().empty());
  }
  printer.at("/z_axis/switch_height_mm") = 160;
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/switch_height_mm: 160 is more than 10 mm away from where the plate touches the "
                   "film, but the switch is at the bottom; one at the top needs z_axis/homes_upwards"});
  printer.at("/z_axis/switch_height_mm") = -10.5;
  printer.at("/z_axis/homes_upwards") = false;
  CHECK(printer.complaints().size() == 1);
}

TEST_CASE("an encoder's tolerance is at least one count") {
  RealPrinterFixture printer;
  printer.at("/z_axis/encoder") = encoder_with("", 20);
  CHECK(printer.complaints().empty());  // 50 um, as without the key
  printer.at("/z_axis/encoder/tolerance_um") = 49;
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/tolerance_um: 49 is less than one count of the encoder, 50 um: every "
                   "move would look as if steps were lost"});
  printer.at("/z_axis/encoder") = encoder_with("", 19);
  CHECK(printer.complaints().size() == 1);
}

TEST_CASE("an encoder's correction per move is more than its tolerance and at most the sum's limit") {
  RealPrinterFixture printer;
  const std::string corrects = R"(, "policy": "correct")";
  printer.at("/z_axis/encoder") = encoder_with(corrects);
  CHECK(printer.complaints().empty());
  printer.at("/z_axis/encoder") = encoder_with(corrects + R"(, "tolerance_um": 300)");
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/most_correction_um: 250 is not more than tolerance_um, 300 um: no move "
                   "would ever be corrected"});
  printer.at("/z_axis/encoder") = encoder_with(corrects + R"(, "most_correction_um": 600)");
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/most_correction_sum_um: 500 is less than most_correction_um for a single "
                   "move, 600 um"});
  printer.at("/z_axis/encoder/policy") = "fault";
  CHECK(printer.complaints().empty());
}

TEST_CASE("an encoder's index needs its distance, more than twice the tolerance, and a line of its own") {
  RealPrinterFixture printer;
  printer.at("/z_axis/encoder") = encoder_with(R"(, "index": {"line": 9}, "index_every_mm": 0.5)");
  CHECK(printer.complaints().empty());
  printer.at("/z_axis/encoder") = encoder_with(R"(, "index": {"line": 8}, "index_every_mm": 0.1)");
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/index: line \"8\" of \"gpiochip0\" is already used for z_axis/encoder/b",
                   "/z_axis/encoder/index_every_mm: 0.1 mm are not more than twice tolerance_um, 50 um: a "
                   "wrong count would never be detected"});
  printer.at("/z_axis/encoder") = encoder_with(R"(, "index": {"line": 9})");
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/index: this needs z_axis/encoder/index_every_mm, which is missing"});
  printer.at("/z_axis/encoder") = encoder_with(R"(, "index_every_mm": 5)");
  CHECK(printer.complaints() ==
        Complaints{"/z_axis/encoder/index_every_mm: this needs z_axis/encoder/index, which is missing"});
}

TEST_CASE("a projector's port and table need each other, and something must be able to turn the light off") {
  const auto complaints_without = [](const char* key) {
    RealPrinterFixture printer;
    printer.remove("projector", key);
    return printer.complaints();
  };
  CHECK(complaints_without("table").back() ==
        "/projector/port: this needs projector/table, which is missing");
  CHECK(complaints_without("port") ==
        Complaints{"/projector/table: this needs projector/port, which is missing"});
  RealPrinterFixture printer;
  printer.at("/projector/table") = "acer";  // a table without a command that turns the light off
  CHECK(printer.complaints() ==
        Complaints{
            "/projector/table: the table \"acer\" has no light_on and light_off: give a \"light\" line too"});
  printer.at("/projector/light") = {{"line", 24}};
  CHECK(printer.complaints().empty());
}

TEST_CASE("a missing projector table is reported with the existing ones") {
  CHECK(
      real_complaints_with("/projector/table", "optima").front().ends_with("there are \"acer\", \"optoma\""));
  CHECK(real_complaints_with("/projector/table", "../projectors/optoma").size() == 1);
}

TEST_CASE("violations of a projector's table are reported with its file, together with the printer's") {
  RealPrinterFixture printer;
  json table = shipped("projectors/optoma.json");
  table["baud"] = "fast";
  printer.write("projectors/optoma.json", table);
  printer.at("/name") = "";
  const auto violations = testing::violations_of([&] { (void)printer.load(); });
  REQUIRE(violations.size() == 2);
  CHECK(violations[0].pointer == "/name");
  CHECK(violations[1].file == (printer.path() / "projectors/optoma.json").string());
}

TEST_CASE("a brightness outside the projector's range is refused") {
  CHECK(real_complaints_with("/projector/brightness", 50) ==
        Complaints{"/projector/brightness: the table \"optoma\" has no brightness"});
}

// Returns the warnings as --check-config prints them, without the file's name.
Complaints warnings_with(const std::string& key, const char* input, const char* hardware = "real") {
  RealPrinterFixture printer;
  printer.at("/z_axis")[key] = json::parse(input);
  printer.at("/hardware") = hardware;
  Complaints warnings;
  for (const Violation& warning : printer.load().warnings) {
    const std::string line = warning_line(warning);
    warnings.push_back(line.substr(line.find(": ") + 2));
  }
  return warnings;
}

TEST_CASE("a contact whose broken wire goes unnoticed causes a warning with the consequence, not an error") {
  const std::string open = "the contact is normally open, so a broken wire goes unnoticed: then ";
  CHECK(warnings_with("emergency_stop", R"({"line": 5})") ==
        Complaints{"warning: /z_axis/emergency_stop: " + open + "pressing it stops nothing"});
  CHECK(warnings_with("lid", R"({"line": 5, "bias": "pull_up", "active_low": true})") ==
        Complaints{"warning: /z_axis/lid: " + open + "the light stays on under an open lid"});
  CHECK(warnings_with("second_switch", R"({"line": 5})") ==
        Complaints{"warning: /z_axis/second_switch: " + open + "a move runs on against the end"});
  CHECK(warnings_with("limit_switch", R"({"line": 5})") ==
        Complaints{"warning: /z_axis/limit_switch: " + open + "homing drives the plate on against its end"});
}

TEST_CASE("a normally closed contact needs a bias that pulls a broken wire away from its level at rest") {
  const auto warnings = [](const char* bias, bool active_low) {
    json input = {{"line", 5}, {"contact", "normally_closed"}, {"active_low", active_low}};
    if (*bias != '\0') input["bias"] = bias;
    return warnings_with("lid", input.dump().c_str());
  };
  CHECK(warnings("pull_up", true).empty());
  CHECK(warnings("pull_down", false).empty());
  CHECK(warnings("pull_down", true) ==
        Complaints{"warning: /z_axis/lid: the bias \"pull_down\" pulls the line to its level at rest, so a "
                   "broken wire goes unnoticed: then the light stays on under an open lid"});
  CHECK(warnings("pull_up", false).size() == 1);
  CHECK(warnings("", true) ==
        Complaints{
            "warning: /z_axis/lid: the bias \"as_is\" leaves a broken wire's level to chance where no "
            "resistor is "
            "fitted (\"pull_up\" would make it noticed): at worst the light stays on under an open lid"});
  CHECK(warnings("off", false).size() == 1);
}

TEST_CASE("a simulated machine's contacts cause no warnings") {
  CHECK(warnings_with("emergency_stop", R"({"line": 5})", "simulated").empty());
}

}  // namespace
}  // namespace contourd
