#include "daemon/config/light_config.hpp"

#include "daemon/config/printer_config.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// The shipped profile of a real machine, with an added light line, and its projector's table.
class RealLightFixture {
 public:
  RealLightFixture() : printer(shipped("raspberry-pi-4.json")), table(shipped("projectors/optoma.json")) {
    printer["projector"]["light"] = {{"line", 24}, {"active_low", true}};
  }
  [[nodiscard]] std::filesystem::path file() const {
    folder.write_json("resins/standard.json", shipped("resins/standard.json"));
    folder.write_json("projectors/optoma.json", table);
    return folder.write_json("printer.json", printer);
  }
  [[nodiscard]] FoundLight find() const { return find_light(file()); }

  ConfigFolder folder;
  json printer, table;
};

const ProjectorTable& table_of(const LightConfig& light) {
  return std::get<SerialProjectorConfig>(light.projector.value()).table;
}

void check_whole(const LightConfig& light) {
  REQUIRE(light.line);
  CHECK(light.line->chip == "gpiochip0");
  CHECK(light.line->line == "24");
  CHECK(light.line->active_low);
  REQUIRE(light.projector);
  CHECK(std::get<SerialProjectorConfig>(*light.projector).port == "/dev/ttyUSB0");
  const ProjectorTable& table = table_of(light);
  CHECK(table.name == "Optoma");
  CHECK(table.baud == 9600);
  CHECK(table.gap == std::chrono::milliseconds{100});
  REQUIRE(table.light_off);
  CHECK(table.light_off->bytes == "~0002 1\r");
  CHECK(table.light_off->timeout == std::chrono::seconds{1});
  REQUIRE(table.light_off->replies.size() == 2);
  CHECK(table.light_off->replies[0].pattern.match_line("P"));
}

TEST_CASE("the record of a valid configuration contains what turns the light off") {
  const RealLightFixture real;
  const PrinterConfig config = load_printer_config(real.file());
  const LightConfig light = read_light_record(real.folder.write("light.json", config.light_record));
  check_whole(light);
  const ProjectorTable& table = table_of(light);
  REQUIRE(table.power);
  CHECK(table.power->bytes == "~00124 1\r");
}

TEST_CASE("a record is marked if contourd exited normally with the light confirmed off") {
  const RealLightFixture real;
  const PrinterConfig config = load_printer_config(real.file());
  CHECK_FALSE(read_light_record(real.folder.write("light.json", config.light_record)).left_dark);
  const LightConfig light =
      read_light_record(real.folder.write("light.json", left_dark(config.light_record)));
  CHECK(light.left_dark);
  check_whole(light);
  CHECK(table_of(light).warm_up == std::chrono::seconds{30});
}

TEST_CASE("the record of a line without a table, or with a table that switches no light, contains the line") {
  RealLightFixture real;
  for (const char* key : {"port", "table"})
    real.printer["projector"].erase(key);
  LightConfig light =
      read_light_record(real.folder.write("light.json", load_printer_config(real.file()).light_record));
  CHECK(light.line->line == "24");
  CHECK_FALSE(light.projector);
  RealLightFixture acer;
  acer.table = shipped("projectors/acer.json");
  light = read_light_record(acer.folder.write("light.json", load_printer_config(acer.file()).light_record));
  CHECK(light.line->line == "24");
  CHECK_FALSE(light.projector);
}

TEST_CASE("a simulated machine has no record") {
  RealLightFixture real;
  real.printer["hardware"] = "simulated";
  CHECK(load_printer_config(real.file()).light_record.empty());
  CHECK_FALSE(real.find().light.line);
  CHECK(real.find().problems.empty());
}

TEST_CASE("an invalid record is an error with its place") {
  const ConfigFolder folder;
  const auto places = [&](const json& record) {
    std::vector<std::string> all;
    for (const Violation& one :
         testing::violations_of([&] { (void)read_light_record(folder.write_json("light.json", record)); }))
      all.push_back(one.pointer);
    return all;
  };
  using Places = std::vector<std::string>;
  CHECK(places(json::array()) == Places{""});
  CHECK(places({{"light", {{"chip", "gpiochip0"}, {"line", 24}}}}) == Places{"/light/active_low"});
  CHECK(places({{"port", "/dev/ttyUSB0"}}) == Places{"/table"});
  json table = json::parse(
      R"({"brand": "A", "baud": 9600, "echo": false, "retries": 2, "gap_ms": 1, "checksum": "none",
    "timeout_ms": 9, "line_end": "", "commands": {"light_off": {"text": "x", "accepted": "(("}}})");
  CHECK(places({{"port", "p"}, {"table", table}}) == Places{"/table"});
  table["commands"]["light_off"]["accepted"] = "P";
  CHECK(places({{"port", "p"}, {"table", table}}).empty());
}

TEST_CASE("mistakes elsewhere do not keep the light from being found") {
  RealLightFixture real;
  real.printer["display"]["colour"] = "blue";
  real.printer["resin"] = "missing";
  real.printer.erase("z_axis");
  real.printer["projector"]["lamp"] = 5;
  real.table["commands"].erase("power_off");
  real.table["commands"]["power"]["on"] = "((";
  real.table["commands"].erase("light_on");
  real.table["warm_up_s"] = -1;
  const FoundLight found = real.find();
  check_whole(found.light);
  CHECK_FALSE(table_of(found.light).power);
  std::vector<std::string> places;
  for (const Violation& violation : found.elsewhere)
    places.push_back(violation.pointer);
  CHECK(places == std::vector<std::string>{"/commands/power/on", "/commands/power_off", "/warm_up_s",
                                           "/display/colour", "/projector/lamp", "/z_axis"});
  // The missing light_on is a problem of light_off, which needs it, but the light can still be turned off.
  REQUIRE(found.problems.size() == 1);
  CHECK(found.problems[0].pointer == "/commands/light_off");
}

TEST_CASE("mistakes in what turns the light off are reported once, and the valid rest is found") {
  RealLightFixture real;
  real.printer["projector"]["port"] = 5;
  FoundLight found = real.find();
  CHECK(found.light.line);
  CHECK_FALSE(found.light.projector);
  REQUIRE(found.problems.size() == 1);
  CHECK(found.problems[0].pointer == "/projector/port");

  real.printer["projector"]["port"] = "/dev/ttyUSB0";
  real.printer["projector"]["light"] = {{"line", true}};
  found = real.find();
  CHECK_FALSE(found.light.line);
  CHECK(found.light.projector);
  REQUIRE(found.problems.size() == 1);
  CHECK(found.problems[0].pointer == "/projector/light/line");

  real.table["commands"]["light_off"]["accepted"] = "((";
  real.printer["projector"].erase("light");
  found = real.find();
  CHECK_FALSE(found.light.projector);
  REQUIRE(found.problems.size() == 1);
  CHECK(found.problems[0].pointer == "/commands/light_off/accepted");
  CHECK(found.elsewhere.empty());
}

TEST_CASE("a configuration in which nothing turns the light off is a problem") {
  RealLightFixture real;
  real.printer["projector"].erase("light");
  real.table = shipped("projectors/acer.json");
  CHECK(real.find().problems.size() == 1);
  CHECK(find_light(real.folder.path() / "none.json").problems.size() == 1);
  CHECK(find_light(real.folder.write("none.json", "{")).problems.size() == 1);
}

}  // namespace
}  // namespace contourd
