#include "daemon/config/plausibility.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

ProjectorTable plausible_table() {
  ProjectorTable table;
  table.baud = 9600;
  table.light_on = ProjectorCommand{.name = "light on", .bytes = "~0002 0\r", .timeout = 1s, .replies = {}};
  table.light_off = ProjectorCommand{.name = "light off", .bytes = "~0002 1\r", .timeout = 1s, .replies = {}};
  return table;
}

std::vector<std::string> warnings_of(const ProjectorTable& table, const ExposureTolerance& tolerance = {},
                                     Duration exposure = 3s) {
  const testing::ConfigFolder folder;
  JsonDocument printer = JsonDocument::from_file(folder.write_json("printer.json", nlohmann::json::object()));
  warn_of_implausible_light(printer, SerialProjectorConfig{"/dev/ttyUSB0", table, {}}, tolerance, exposure);
  std::vector<std::string> warnings;
  for (const Violation& warning : printer.warnings()) {
    CHECK(warning.pointer == "/projector/table");
    warnings.push_back(warning.message);
  }
  return warnings;
}

// Returns the pointers of the warnings.
std::vector<std::string> implausible_in_display(double width, double height, double pitch_um = 50) {
  const nlohmann::json file{
      {"display", {{"width_px", width}, {"height_px", height}, {"pixel_pitch_um", pitch_um}}}};
  JsonDocument printer = JsonDocument::from_text(file.dump(), "printer.json");
  warn_of_implausible_display(printer);
  std::vector<std::string> places;
  for (const Violation& warning : printer.warnings())
    places.push_back(warning.pointer);
  return places;
}

using Pointers = std::vector<std::string>;

// Returns the pointers of the warnings about the shipped resin with these changes, at 5 mW/cm2.
std::vector<std::string> implausible_in_resin(const nlohmann::json& changes = nlohmann::json::object()) {
  nlohmann::json profile = testing::shipped("resins/standard.json");
  profile.merge_patch(changes);
  const testing::ConfigFolder folder;
  const auto file = folder.write_json("resin.json", profile);
  std::vector<std::string> places;
  for (const Violation& warning : implausible_values(load_resin_profile(file, {}), file, 5)) {
    CHECK(warning.file == file.string());
    places.push_back(warning.pointer);
  }
  return places;
}

}  // namespace

TEST_CASE("a table whose timing is within the resin's tolerance causes no warning") {
  CHECK(warnings_of(plausible_table()).empty());
  ProjectorTable lamp = plausible_table();
  lamp.light_on.reset(), lamp.light_off.reset(), lamp.latency = 5s;
  CHECK(warnings_of(lamp).empty());  // a line switches the light
}

TEST_CASE("a table whose timing exceeds the resin's tolerance causes a warning with the consequence") {
  ProjectorTable slow = plausible_table();
  slow.baud = 1200;  // 160 bits
  CHECK(warnings_of(slow) ==
        std::vector<std::string>{"light_on and light_off alone take 133 ms at 1200 baud: the resin's "
                                 "exposure_tolerance_ms is 100 ms, so every layer will cause a warning"});
  ProjectorTable late = plausible_table();
  late.latency = 150ms;
  CHECK(
      warnings_of(late, {100ms, ExposureTolerance::Policy::Interrupt}) ==
      std::vector<std::string>{"its latency_ms is 150 ms, and light_off is hardly faster than light_on: the "
                               "resin's exposure_tolerance_ms is 100 ms, so every layer will wait for the "
                               "operator"});
  CHECK(warnings_of(late, {200ms, ExposureTolerance::Policy::Warn}).empty());
}

TEST_CASE("a reply timeout longer than the exposure causes a warning") {
  CHECK(warnings_of(plausible_table(), {}, 1s) ==
        std::vector<std::string>{
            "the reply to light_on may take 1000 ms, but the resin's exposure is 1000 ms: "
            "a lost reply is noticed only after the exposure, and then it is unknown whether "
            "there was light"});
  CHECK(warnings_of(plausible_table(), {}, 1001ms).empty());
}

TEST_CASE("a gap longer than the exposure causes a warning") {
  ProjectorTable slow = plausible_table();
  slow.gap = 1s, slow.light_on->timeout = 300ms;
  CHECK(warnings_of(slow, {}, 500ms) ==
        std::vector<std::string>{
            "its gap_ms is 1000 ms: light_off comes 1008 ms after light_on at the "
            "soonest, but the resin's exposure is 500 ms: layers with this exposure get more light"});
  CHECK(warnings_of(slow, {}, 1009ms).empty());
}

TEST_CASE("displays of existing projectors are plausible") {
  CHECK(implausible_in_display(1024, 768, 100).empty());
  CHECK(implausible_in_display(1280, 720, 80).empty());
  CHECK(implausible_in_display(1280, 800).empty());
  CHECK(implausible_in_display(1280, 1024).empty());
  CHECK(implausible_in_display(1920, 1080).empty());
  CHECK(implausible_in_display(2560, 1440, 51).empty());
  CHECK(implausible_in_display(3840, 2160, 30).empty());
  CHECK(implausible_in_display(2560, 1080).empty());
}

TEST_CASE("swapped width and height, a missing digit and a pitch in another unit are implausible") {
  CHECK(implausible_in_display(1080, 1920) == Pointers{"/display/height_px"});
  CHECK(implausible_in_display(1920, 108) == Pointers{"/display/width_px"});
  CHECK(implausible_in_display(192, 1080) == Pointers{"/display/height_px"});
  CHECK(implausible_in_display(1080, 1080) == Pointers{"/display/width_px"});
  CHECK(implausible_in_display(1920, 1080, 5) == Pointers{"/display/pixel_pitch_um"});
  CHECK(implausible_in_display(1920, 1080, 500) == Pointers{"/display/pixel_pitch_um"});
}

TEST_CASE("an invalid display causes no warnings") {
  JsonDocument printer = JsonDocument::from_text(R"({"display": {"width_px": "wide"}})", "printer.json");
  warn_of_implausible_display(printer);
  CHECK(printer.warnings().empty());
}

TEST_CASE("the shipped resin and the values of existing printers are plausible") {
  CHECK(implausible_in_resin().empty());
  // Other hosts' values for 25 and 100 um, and those of a strong lamp.
  CHECK(implausible_in_resin({{"layer_height_um", 25}, {"exposure_ms", 2500}, {"bottom_exposure_ms", 5000}})
            .empty());
  CHECK(
      implausible_in_resin({{"layer_height_um", 100}, {"exposure_ms", 14000}, {"bottom_exposure_ms", 35000}})
          .empty());
  CHECK(implausible_in_resin({{"exposure_ms", 500}, {"bottom_exposure_ms", 1000}}).empty());
  CHECK(implausible_in_resin(
            {{"bottom_layers", 0}, {"fade_layers", 0}, {"exposure_ms", 800}, {"bottom_exposure_ms", 900}})
            .empty());
}

TEST_CASE("seconds entered as milliseconds are implausible in every exposure") {
  CHECK(implausible_in_resin({{"exposure_ms", 3}}) == Pointers{"/exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 3}, {"bottom_exposure_ms", 30}}) ==
        Pointers{"/exposure_ms", "/bottom_exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 120}}) == Pointers{"/exposure_ms"});
  CHECK(implausible_in_resin({{"exposure_ms", 90000}, {"bottom_exposure_ms", 90000}}) ==
        Pointers{"/exposure_ms"});
}

TEST_CASE("an exposure for a different thickness is implausible") {
  const nlohmann::json thick{{"layer_height_um", 200}, {"layer_height_max_um", 200}, {"exposure_ms", 1000}};
  CHECK(implausible_in_resin(thick) == Pointers{"/exposure_ms"});
  const nlohmann::json thin{{"layer_height_um", 12}, {"layer_height_min_um", 10}, {"exposure_ms", 15000}};
  CHECK(implausible_in_resin(thin) == Pointers{"/exposure_ms"});
}

TEST_CASE("exposures from a working curve are checked like given ones") {
  const auto curve = [](double ec, double overcure) {
    return nlohmann::json{{"exposure_ms", nullptr},
                          {"bottom_exposure_ms", nullptr},
                          {"working_curve",
                           {{"penetration_depth_um", 150},
                            {"critical_energy_mj_cm2", ec},
                            {"overcure_um", overcure},
                            {"bottom_overcure_um", 300}}}};
  };
  CHECK(implausible_in_resin(curve(9, 60)).empty());
  CHECK(implausible_in_resin(curve(0.09, 60)) == Pointers{"/working_curve", "/working_curve"});
  CHECK(implausible_in_resin(curve(9, 0)) == Pointers{"/working_curve/overcure_um"});
}

TEST_CASE("layer heights and moves outside those of existing printers are implausible") {
  CHECK(implausible_in_resin({{"layer_height_um", 5}, {"layer_height_min_um", 5}, {"exposure_ms", 1000}}) ==
        Pointers{"/layer_height_um"});
  CHECK(implausible_in_resin({{"lift_mm", 0.5}, {"second_lift_mm", 0.4}}) == Pointers{"/lift_mm"});
  CHECK(implausible_in_resin({{"lift_mm", 60}}) == Pointers{"/lift_mm"});
  CHECK(implausible_in_resin({{"lift_speed_mm_s", 40}, {"retract_speed_mm_s", 45}}) ==
        Pointers{"/lift_speed_mm_s", "/retract_speed_mm_s"});
}
