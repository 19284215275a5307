#include "hw/drm/color.hpp"

#include "tests/catch.hpp"

namespace {

Mode timing(int width, int height, int line) {
  Mode mode{};
  mode.hdisplay = static_cast<std::uint16_t>(width);
  mode.vdisplay = static_cast<std::uint16_t>(height);
  mode.htotal = static_cast<std::uint16_t>(line);
  return mode;
}

// The properties of an object that does not exist: none.
const ObjectProperties kNoProperties(-1, 0, 0);

}  // namespace

TEST_CASE("The identity gamma table runs from 0 to 0xffff in equal steps, whatever its size") {
  CHECK(identity_gamma(2) == std::vector<std::uint16_t>{0, 0xffff});
  CHECK(identity_gamma(256)[1] == 0x0101);
  CHECK(identity_gamma(256).back() == 0xffff);
  CHECK(identity_gamma(1025)[512] == 0x8000);
  CHECK(identity_gamma(1).size() == 1);
  for (const std::size_t size : {2U, 33U, 256U, 1024U, 4096U})
    CHECK(is_identity_gamma(identity_gamma(size)));
}

TEST_CASE(
    "A table stored with fewer than 16 bits still counts as the identity, but one that changes pixels does "
    "not") {
  std::vector<std::uint16_t> table = identity_gamma(256);
  for (std::uint16_t& value : table)
    value &= 0xff00;  // the kernel's own first table
  CHECK(is_identity_gamma(table));

  for (const auto& [at, value] : {std::pair{0, 0x1000}, std::pair{128, 0x8383}, std::pair{255, 0xebeb}}) {
    std::vector<std::uint16_t> other = identity_gamma(256);
    other[static_cast<std::size_t>(at)] = static_cast<std::uint16_t>(value);
    CHECK_FALSE(is_identity_gamma(other));
  }
}

TEST_CASE(
    "Television modes are recognized by their timing, and computer modes of the same size are not television "
    "modes") {
  CHECK(is_television_mode(timing(1920, 1080, 2200)));
  CHECK(is_television_mode(timing(1280, 720, 1980)));
  CHECK(is_television_mode(timing(3840, 2160, 4400)));
  CHECK_FALSE(is_television_mode(timing(1920, 1080, 2080)));  // CVT, reduced blanking
  CHECK_FALSE(is_television_mode(timing(1280, 800, 1680)));
  CHECK_FALSE(is_television_mode(timing(2560, 1440, 2720)));
  CHECK_FALSE(is_television_mode(timing(640, 480, 800)));  // sent in full range, as all computer modes
}

TEST_CASE("A range that cannot be set gives a warning for connectors and modes with a limited range") {
  const Mode television = timing(1920, 1080, 2200);
  const auto warning =
      range_warning("HDMI-A-1", television, kNoProperties, "HDMI-A-1 of /dev/dri/card0 (vc4)");
  REQUIRE(warning);
  CHECK(warning->starts_with("HDMI-A-1 of /dev/dri/card0 (vc4) has no \"Broadcast RGB\""));
  CHECK(warning->find("16 of 255, 6 % of the light") != std::string::npos);
  CHECK(range_warning("DP-1", television, kNoProperties, "DP-1"));
  CHECK_FALSE(range_warning("DVI-D-1", television, kNoProperties, "DVI-D-1"));
  CHECK_FALSE(range_warning("Virtual-1", television, kNoProperties, "Virtual-1"));
  CHECK_FALSE(range_warning("HDMI-A-1", timing(1280, 800, 1680), kNoProperties, "HDMI-A-1"));
}

TEST_CASE("An object without properties needs no changes") {
  CHECK(changes_to_neutral(kNoProperties, kNoProperties).empty());
}
