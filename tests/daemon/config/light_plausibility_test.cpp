#include "daemon/config/light_plausibility.hpp"

#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

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
  warn_of_implausible_light(printer, table, tolerance, exposure);
  std::vector<std::string> warnings;
  for (const Violation& warning : printer.warnings()) {
    CHECK(warning.pointer == "/projector/table");
    warnings.push_back(warning.message);
  }
  return warnings;
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
