#include "hw/drm/mode.hpp"

#include "tests/catch.hpp"
#include "tests/hw/refusal.hpp"

namespace {

// Returns a mode with blanking of 200 x 50 pixels and the pixel clock for that refresh.
Mode mode_of(int width, int height, double hz, std::uint32_t flags = 0, std::uint32_t type = 0) {
  Mode mode{};
  mode.hdisplay = static_cast<std::uint16_t>(width);
  mode.vdisplay = static_cast<std::uint16_t>(height);
  mode.htotal = static_cast<std::uint16_t>(width + 200);
  mode.vtotal = static_cast<std::uint16_t>(height + 50);
  mode.clock = static_cast<std::uint32_t>(hz * mode.htotal * mode.vtotal / 1000 + 0.5);
  mode.vrefresh = static_cast<std::uint32_t>(hz + 0.5);
  mode.flags = flags;
  mode.type = type;
  return mode;
}

DrmDisplayConfig wanting(int width, int height, double hz) {
  DrmDisplayConfig config;
  config.width = Pixels{width};
  config.height = Pixels{height};
  config.refresh_hz = hz;
  return config;
}

Mode chosen_mode(const std::vector<Mode>& modes, const DrmDisplayConfig& config, PictureSize size = {}) {
  return choose_mode(modes, size, config, "HDMI-A-1 of /dev/dri/card0 (vc4)");
}

std::string refusal_of_modes(const std::vector<Mode>& modes, const DrmDisplayConfig& config,
                             PictureSize size = {}) {
  return testing::refusal_of([&] { return chosen_mode(modes, config, size); });
}

}  // namespace

TEST_CASE("A mode's refresh is computed from its pixel clock") {
  Mode mode{};  // CEA-861 format 16, then one that is 1/1000 slower
  mode.clock = 148'500;
  mode.htotal = 2200;
  mode.vtotal = 1125;
  CHECK(refresh_hz(mode) == testing::Approx(60.0));
  mode.clock = 148'352;
  CHECK(refresh_hz(mode) == testing::Approx(59.94).epsilon(0.0001));
}

TEST_CASE("The mode of the wanted size with the nearest refresh is chosen") {
  const std::vector<Mode> modes{mode_of(1280, 720, 60), mode_of(1920, 1080, 59.94), mode_of(1920, 1080, 60),
                                mode_of(1920, 1080, 50)};
  CHECK(refresh_hz(chosen_mode(modes, wanting(1920, 1080, 60))) == testing::Approx(60.0).epsilon(0.0001));
  CHECK(refresh_hz(chosen_mode(modes, wanting(1920, 1080, 59.94))) == testing::Approx(59.94).epsilon(0.0001));
  CHECK(refresh_hz(chosen_mode(modes, wanting(1920, 1080, 50.4))) == testing::Approx(50.0).epsilon(0.0001));
}

TEST_CASE("Among equally near modes the display's preferred one is chosen, else the first") {
  std::vector<Mode> modes{mode_of(1920, 1080, 60), mode_of(1920, 1080, 60), mode_of(1920, 1080, 60)};
  std::strcpy(modes[0].name, "first");
  std::strcpy(modes[1].name, "second");
  CHECK(std::string(chosen_mode(modes, wanting(1920, 1080, 60)).name) == "first");
  modes[1].type = DRM_MODE_TYPE_PREFERRED;
  CHECK(std::string(chosen_mode(modes, wanting(1920, 1080, 60)).name) == "second");
}

TEST_CASE("A preferred mode does not win over a nearer one") {
  const std::vector<Mode> modes{mode_of(1920, 1080, 60.2, 0, DRM_MODE_TYPE_PREFERRED),
                                mode_of(1920, 1080, 60)};
  CHECK(refresh_hz(chosen_mode(modes, wanting(1920, 1080, 60))) == testing::Approx(60.0).epsilon(0.0001));
}

TEST_CASE("If no mode fits, the error names the connector, the wanted mode and the modes that exist") {
  const std::vector<Mode> modes{mode_of(1280, 720, 60), mode_of(1280, 720, 60), mode_of(1024, 768, 75)};
  CHECK(refusal_of_modes(modes, wanting(1920, 1080, 60)) ==
        "HDMI-A-1 of /dev/dri/card0 (vc4) has no mode of 1920x1080 at 60.00 Hz; modes: 1280x720 at 60.00 Hz; "
        "1024x768 at 75.00 Hz");
  CHECK(refusal_of_modes({}, wanting(1920, 1080, 60)) ==
        "HDMI-A-1 of /dev/dri/card0 (vc4) has no mode of 1920x1080 at 60.00 Hz; modes: none");
}

TEST_CASE("A mode whose refresh is off by more than half a hertz does not fit") {
  CHECK(refusal_of_modes({mode_of(1920, 1080, 60.4)}, wanting(1920, 1080, 60)).empty());
  CHECK_FALSE(refusal_of_modes({mode_of(1920, 1080, 60.6)}, wanting(1920, 1080, 60)).empty());
}

TEST_CASE("Modes that do not send each pixel of each picture once are skipped, and named if no other fits") {
  const Mode interlaced = mode_of(1920, 1080, 30, DRM_MODE_FLAG_INTERLACE);  // 60 half pictures
  const Mode plain = mode_of(1920, 1080, 60.1);
  CHECK(refresh_hz(chosen_mode({interlaced, plain}, wanting(1920, 1080, 60))) ==
        testing::Approx(60.1).epsilon(0.0001));
  CHECK(refusal_of_modes({interlaced}, wanting(1920, 1080, 60)) ==
        "HDMI-A-1 of /dev/dri/card0 (vc4) cannot show masks with its mode 1920x1080 at 60.00 Hz, interlaced: "
        "it does not send each pixel of each picture once; modes: 1920x1080 at 60.00 Hz, interlaced");
  CHECK(why_unsuitable(mode_of(640, 480, 60, DRM_MODE_FLAG_DBLSCAN), {}).has_value());
  CHECK(why_unsuitable(mode_of(1440, 480, 60, DRM_MODE_FLAG_DBLCLK), {}).has_value());
  CHECK(why_unsuitable(mode_of(1920, 1080, 60, DRM_MODE_FLAG_3D_FRAME_PACKING), {}).has_value());
}

TEST_CASE("A mode whose aspect ratio makes its pixels non-square is refused") {
  CHECK_FALSE(why_unsuitable(mode_of(1920, 1080, 60, DRM_MODE_FLAG_PIC_AR_16_9), {}).has_value());
  CHECK_FALSE(why_unsuitable(mode_of(640, 480, 60, DRM_MODE_FLAG_PIC_AR_4_3), {}).has_value());
  CHECK(why_unsuitable(mode_of(720, 576, 50, DRM_MODE_FLAG_PIC_AR_16_9), {}) ==
        "its pixels are not square: in a picture of 16:9 they are 1.42 times as wide as high");
  CHECK(why_unsuitable(mode_of(720, 480, 60, DRM_MODE_FLAG_PIC_AR_4_3), {}).has_value());
}

TEST_CASE("A picture size that makes the pixels non-square is refused, unless the config ignores it") {
  const Mode mode = mode_of(1920, 1080, 60);
  CHECK_FALSE(why_unsuitable(mode, {}).has_value());          // projectors have no size
  CHECK_FALSE(why_unsuitable(mode, {530, 300}).has_value());  // a 24 inch panel in whole centimetres
  CHECK_FALSE(why_unsuitable(mode_of(1280, 800, 60), {70, 40}).has_value());  // 65x41 mm in whole centimetres
  CHECK_FALSE(why_unsuitable(mode, {160, 90}).has_value());                   // the ratio in place of a size
  CHECK_FALSE(why_unsuitable(mode, {120, 0}).has_value());                    // one side is not enough
  CHECK(why_unsuitable(mode, {400, 300}) ==
        "its pixels are not square: on a picture of 400x300 mm they are 0.75 times as wide as high");
  CHECK(why_unsuitable(mode_of(1024, 768, 60), {530, 300}).has_value());  // stretched over a wide panel
  DrmDisplayConfig config = wanting(1920, 1080, 60);
  CHECK_FALSE(refusal_of_modes({mode}, config, {400, 300}).empty());
  config.ignore_edid_size = true;
  CHECK(refusal_of_modes({mode}, config, {400, 300}).empty());
}

TEST_CASE("Modes of the same timing are the same mode, even if their names differ") {
  Mode a = mode_of(1920, 1080, 60), b = a;
  std::strcpy(b.name, "other");
  b.type = DRM_MODE_TYPE_PREFERRED;
  CHECK(same_timing(a, b));
  b.clock += 1;
  CHECK_FALSE(same_timing(a, b));
}
