// Tests that the functions of daemon/config, daemon/json and daemon/system check their requirements.
#include "daemon/config/light_config.hpp"
#include "daemon/config/plausibility.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/system/utf_8.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("A ConfigError has at least one violation") {
  CHECK(contract_broken_by([] { ConfigError(std::vector<Violation>{}); }) ==
        "there is at least one violation");
}

TEST_CASE("A code point is of exactly one character") {
  CHECK(contract_broken_by([] { (void)code_point("\xC3\xA9"); }).empty());
  for (const char* text : {"", "ab", "\xC3", "\xFF"})
    CHECK(contract_broken_by([text] { (void)code_point(text); }) == "it is one character");
}

TEST_CASE("A light record requires a printer with a projector, and its mark requires JSON") {
  const JsonDocument printer = JsonDocument::from_text(R"({"projector": {}})", "printer.json");
  const JsonDocument nothing = JsonDocument::from_text("{}", "printer.json");
  CHECK(contract_broken_by([&] { (void)light_record(printer, {}); }).empty());
  CHECK(contract_broken_by([&] { (void)light_record(nothing, {}); }) == "the printer has a projector");
  CHECK(contract_broken_by([] { (void)left_dark("{}"); }).empty());
  CHECK(contract_broken_by([] { (void)left_dark("{"); }) == "the record is JSON text");
}

TEST_CASE("An exposure requires a valid layer and irradiance") {
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
