#include "daemon/config/uniformity_mask.hpp"

#include <fstream>

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;

// A printer with 30 x 20 pixels and the given display keys, and its loaded mask.
struct LoadedMask {
  explicit LoadedMask(const ConfigFolder& folder, json display) {
    display["width_px"] = 30;
    display["height_px"] = 20;
    printer = JsonDocument::from_text(json{{"display", display}}.dump(), "printer.json");
    mask = load_uniformity_mask(printer, folder.path());
  }

  JsonDocument printer = JsonDocument::from_text("{}", "printer.json");
  std::optional<UniformityMask> mask;
};

Mask picture(int width, int height) {
  Mask mask(Pixels{width}, Pixels{height});
  mask.row(3)[4] = 200;
  return mask;
}

TEST_CASE("a uniformity mask is read from the file that its key names, and is absent by default") {
  const ConfigFolder folder;
  write_png(folder.path() / "even.png", picture(30, 20));
  const LoadedMask named(folder, {{"uniformity_mask", "even.png"}});
  REQUIRE(named.mask);
  CHECK(named.mask->mask == picture(30, 20));
  CHECK(named.mask->file == folder.path() / "even.png");
  CHECK(named.printer.violations().empty());
  CHECK(named.printer.warnings().empty());
  CHECK_FALSE(LoadedMask(folder, json::object()).mask);
}

TEST_CASE("an unusable uniformity mask is refused at the key that names it, with its path") {
  const ConfigFolder folder;
  const std::filesystem::path file = folder.path() / "even.png";
  const auto complaint = [&] {
    const LoadedMask bad(folder, {{"uniformity_mask", "even.png"}});
    CHECK_FALSE(bad.mask);
    const std::vector<Violation> violations = bad.printer.violations();
    REQUIRE(violations.size() == 1);
    CHECK(violations[0].pointer == "/display/uniformity_mask");
    return violations[0].message;
  };
  CHECK(complaint() == file.string() + ": No such file or directory");
  write_png(file, picture(20, 30));
  CHECK(complaint() == file.string() + ": the picture is 20x30 pixels, the display 30x20");
  std::ofstream(file) << "no picture";
  CHECK(complaint() == file.string() + ": the file is not a PNG file");
}

}  // namespace
}  // namespace contourd
