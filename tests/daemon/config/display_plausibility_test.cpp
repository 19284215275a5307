#include "daemon/config/display_plausibility.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"

using namespace contourd;

namespace {

std::vector<std::string> implausible(double width, double height, double pitch_um = 50) {
  const nlohmann::json file{
      {"display", {{"width_px", width}, {"height_px", height}, {"pixel_pitch_um", pitch_um}}}};
  JsonDocument printer = JsonDocument::from_text(file.dump(), "printer.json");
  warn_of_implausible_display(printer);
  std::vector<std::string> places;
  for (const Violation& warning : printer.warnings())
    places.push_back(warning.pointer);
  return places;
}

using Places = std::vector<std::string>;

}  // namespace

TEST_CASE("displays that projectors have are not implausible") {
  CHECK(implausible(1024, 768, 100).empty());
  CHECK(implausible(1280, 720, 80).empty());
  CHECK(implausible(1280, 800).empty());
  CHECK(implausible(1280, 1024).empty());
  CHECK(implausible(1920, 1080).empty());
  CHECK(implausible(2560, 1440, 51).empty());
  CHECK(implausible(3840, 2160, 30).empty());
  CHECK(implausible(2560, 1080).empty());
}

TEST_CASE(
    "width and height exchanged, a digit that is missing, and a pitch in another unit are implausible") {
  CHECK(implausible(1080, 1920) == Places{"/display/height_px"});
  CHECK(implausible(1920, 108) == Places{"/display/width_px"});
  CHECK(implausible(192, 1080) == Places{"/display/height_px"});
  CHECK(implausible(1080, 1080) == Places{"/display/width_px"});
  CHECK(implausible(1920, 1080, 5) == Places{"/display/pixel_pitch_um"});
  CHECK(implausible(1920, 1080, 500) == Places{"/display/pixel_pitch_um"});
}

TEST_CASE("of a display that is wrong in itself nothing is implausible") {
  JsonDocument printer = JsonDocument::from_text(R"({"display": {"width_px": "wide"}})", "printer.json");
  warn_of_implausible_display(printer);
  CHECK(printer.warnings().empty());
}
