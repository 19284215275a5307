#include "daemon/config/config_edit.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include "daemon/config/printer_config.hpp"
#include "daemon/json/config_error.hpp"
#include "tests/catch.hpp"
#include "tests/daemon/config/config_fixture.hpp"

namespace contourd {
namespace {

std::string height_set(const std::string& text, double height = -1.25) {
  return with_number(text, "z_axis", "switch_height_mm", height);
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_CASE("A number is replaced in place, and the rest of the text is unchanged") {
  CHECK(height_set(R"({ "name":"a",
   "z_axis" : {"travel_mm": 1, "switch_height_mm" :0.5 , "x": [1,2]} })") == R"({ "name":"a",
   "z_axis" : {"travel_mm": 1, "switch_height_mm" :-1.25 , "x": [1,2]} })");
  CHECK(height_set(R"({"z_axis": {"switch_height_mm": -1e1}})", 0.1) ==
        R"({"z_axis": {"switch_height_mm": 0.1}})");
}

TEST_CASE("A missing number is inserted as the first key of its section") {
  CHECK(height_set("{\"z_axis\": {\n    \"travel_mm\": 1}}") ==
        "{\"z_axis\": {\n    \"switch_height_mm\": -1.25,\n    \"travel_mm\": 1}}");
  CHECK(height_set(R"({"z_axis": {}})") == R"({"z_axis": {"switch_height_mm": -1.25}})");
}

TEST_CASE("A text that cannot be edited in place is refused with an instruction") {
  for (const char* text : {R"({})", R"({"z_axis": {"deep": {"switch_height_mm": 1}}})",
                           R"({"other": {"switch_height_mm": 1}, "z_axis": {"switch_height_mm": 1}})",
                           R"({"z_axis": {"switch_height\u005fmm": 1}})"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(
        height_set(text),
        "/z_axis/switch_height_mm cannot be changed in this file automatically: set it to -1.25 by hand");
  }
}

TEST_CASE("A file beside another gets its permissions, or is not there at all") {
  ConfigFolder folder;
  const std::filesystem::path file = folder.write_json("printer.json", nlohmann::json::object());
  std::filesystem::permissions(file, std::filesystem::perms(0640));
  const std::string content(3 << 20, 'x');
  const std::filesystem::path mask = file.parent_path() / "mask.png";
  write_beside(file, mask, content);
  CHECK(text_of(mask) == content);
  CHECK(std::filesystem::status(mask).permissions() == std::filesystem::perms(0640));
  CHECK_FALSE(std::filesystem::exists(mask.string() + ".new"));
  std::filesystem::create_directories(file.parent_path() / "taken.png" / "below");
  CHECK_THROWS_AS(write_beside(file, file.parent_path() / "taken.png", content), std::system_error);
  CHECK_FALSE(std::filesystem::exists(file.parent_path() / "taken.png.new"));
}

TEST_CASE(
    "Setting a number of a configuration keeps the permissions, and an invalid number changes nothing") {
  ConfigFolder folder;
  folder.write_json("resins/standard.json", shipped("resins/standard.json"));
  nlohmann::json printer = shipped("contourd.json");
  printer["resins_folder"] = "resins";
  const std::filesystem::path file = folder.write_json("printer.json", printer);
  const auto link = file.parent_path() / "link.json";
  std::filesystem::create_symlink(file, link);
  std::filesystem::permissions(file, std::filesystem::perms(0640));

  set_config_number(link, "z_axis", "travel_mm", 123.5);
  CHECK(load_printer_config(file).travel == Nanometers{123'500'000});
  CHECK(std::filesystem::is_symlink(link));
  struct stat status {};
  REQUIRE(::stat(file.c_str(), &status) == 0);
  CHECK((status.st_mode & 07777U) == 0640);

  const std::string before = text_of(file);
  CHECK_THROWS_AS(set_config_number(file, "z_axis", "travel_mm", -1), ConfigError);
  CHECK(text_of(file) == before);
  CHECK_FALSE(std::filesystem::exists(file.string() + ".new"));
}

}  // namespace
}  // namespace contourd
