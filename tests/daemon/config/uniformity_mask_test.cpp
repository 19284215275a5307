#include "daemon/config/uniformity_mask.hpp"

#include <fstream>
#include <string>

#include "hw/png_file.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

using nlohmann::json;
using testing::ConfigFolder;

// A printer of 30 x 20 pixels, with these keys beside them, and what became of its mask.
struct Loaded {
  explicit Loaded(const ConfigFolder& folder, json display) {
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

TEST_CASE("a uniformity mask is read from the file that its key names, and there is none by default") {
  const ConfigFolder folder;
  write_png(folder.path() / "even.png", picture(30, 20));
  const Loaded named(folder, {{"uniformity_mask", "even.png"}});
  REQUIRE(named.mask);
  CHECK(named.mask->mask == picture(30, 20));
  CHECK(named.mask->file == folder.path() / "even.png");
  CHECK(named.printer.violations().empty());
  CHECK(named.printer.warnings().empty());
  CHECK_FALSE(Loaded(folder, json::object()).mask);
}

TEST_CASE("the old key of the uniformity mask works, with a warning that tells the new one") {
  const ConfigFolder folder;
  write_png(folder.path() / "even.png", picture(30, 20));
  const Loaded old(folder, {{"lamp_mask", "even.png"}});
  REQUIRE(old.mask);
  CHECK(old.mask->mask == picture(30, 20));
  CHECK(old.printer.violations().empty());
  CHECK(old.printer.warnings() ==
        std::vector<Violation>{{"printer.json", "/display/lamp_mask",
                                "this key is now called \"uniformity_mask\"; the old name still works"}});
}

TEST_CASE("both keys of the uniformity mask together are refused") {
  const ConfigFolder folder;
  write_png(folder.path() / "even.png", picture(30, 20));
  const Loaded both(folder, {{"uniformity_mask", "even.png"}, {"lamp_mask", "even.png"}});
  CHECK(both.printer.violations() ==
        std::vector<Violation>{{"printer.json", "/display/lamp_mask",
                                "this is the old name of \"uniformity_mask\", which is there too"}});
}

TEST_CASE("a uniformity mask that cannot be used is refused at the key that names it, with its path") {
  const ConfigFolder folder;
  const std::filesystem::path file = folder.path() / "even.png";
  for (const std::string key : {"uniformity_mask", "lamp_mask"}) {
    const auto complaint = [&] {
      const Loaded bad(folder, {{key, "even.png"}});
      CHECK_FALSE(bad.mask);
      const std::vector<Violation> violations = bad.printer.violations();
      REQUIRE(violations.size() == 1);
      CHECK(violations[0].pointer == "/display/" + key);
      return violations[0].message;
    };
    std::filesystem::remove(file);
    CHECK(complaint() == file.string() + ": No such file or directory");
    write_png(file, picture(20, 30));
    CHECK(complaint() == file.string() + ": the picture is 20x30 pixels, the display 30x20");
    std::ofstream(file) << "no picture";
    CHECK(complaint() == file.string() + ": the file is not a PNG file");
  }
}

}  // namespace
}  // namespace contourd
