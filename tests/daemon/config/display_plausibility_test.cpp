#include "daemon/config/display_plausibility.hpp"

#include "tests/catch.hpp"

namespace {

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

}  // namespace

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
