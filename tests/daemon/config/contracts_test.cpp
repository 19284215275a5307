// That each header of daemon/config checks what it requires.
#include "daemon/config/light_config.hpp"
#include "daemon/config/resin_plausibility.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_syntax.hpp"
#include "daemon/system/utf_8.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using testing::contract_broken_by;

TEST_CASE("A ConfigError says what is wrong") {
  CHECK(contract_broken_by([] { ConfigError(std::vector<Violation>{}); }) == "something is wrong");
}

TEST_CASE("JSON is looked at behind its byte order mark") {
  CHECK(contract_broken_by([] { (void)check_json_syntax("{}", "a.json"); }).empty());
  CHECK(contract_broken_by([] { (void)check_json_syntax("\xEF\xBB\xBF{}", "a.json"); }) ==
        "there is no byte order mark");
}

TEST_CASE("A code point is one character's") {
  CHECK(contract_broken_by([] { (void)code_point("\xC3\xA9"); }).empty());
  for (const char* text : {"", "ab", "\xC3", "\xFF"})
    CHECK(contract_broken_by([text] { (void)code_point(text); }) == "it is one character");
}

TEST_CASE("A light's record is of a printer with a projector, and is marked as the record that it is") {
  const JsonDocument printer = JsonDocument::from_text(R"({"projector": {}})", "printer.json");
  const JsonDocument nothing = JsonDocument::from_text("{}", "printer.json");
  CHECK(contract_broken_by([&] { (void)light_record(printer, {}); }).empty());
  CHECK(contract_broken_by([&] { (void)light_record(nothing, {}); }) == "the printer has a projector");
  CHECK(contract_broken_by([] { (void)left_dark("{}"); }).empty());
  CHECK(contract_broken_by([] { (void)left_dark("{"); }) == "the text is a record's");
}

TEST_CASE("An exposure is of a layer of a print, under light") {
  const ResinProfile resin{};
  const std::string layer = "the layer is one of a print", light = "there is light";
  CHECK(contract_broken_by([&] { (void)exposure_time(resin, Nanometers{1}, 0, 1); }).empty());
  CHECK(contract_broken_by([&] { (void)exposure_time(resin, Nanometers{1}, -1, 1); }) == layer);
  CHECK(contract_broken_by([&] { (void)exposure_time(resin, Nanometers{0}, 0, 1); }) == layer);
  CHECK(contract_broken_by([&] { (void)exposure_time(resin, Nanometers{1}, 0, 0); }) == light);
  CHECK(contract_broken_by([&] { (void)implausible_values(resin, "resin.json", 0); }) == light);
  const std::string both = "the layer has a thickness, and there is light";
  CHECK(contract_broken_by([&] { (void)layer_height_problems(resin, Nanometers{0}, 1); }) == both);
  CHECK(contract_broken_by([&] { (void)layer_height_problems(resin, Nanometers{1}, -1); }) == both);
}
