// The config of the output that shows the masks. Value type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/geometry/units.hpp"

namespace contourd {

enum class PixelFormat {
  Xrgb8888,  // DRM_FORMAT_XRGB8888: 32-bit words 0x00rrggbb in the processor's byte order
  Rgb565,    // DRM_FORMAT_RGB565: 16-bit words, rrrrrggggggbbbbb
};

[[nodiscard]] constexpr std::size_t bytes_per_pixel(PixelFormat format) {
  return format == PixelFormat::Xrgb8888 ? 4 : 2;
}

// Both return a pixel with the grey value in all three colours. In RGB565 each colour is rounded to its
// nearest representable value.
[[nodiscard]] constexpr std::uint32_t xrgb8888(std::uint8_t grey) {
  return static_cast<std::uint32_t>(grey) * 0x010101U;
}
[[nodiscard]] constexpr std::uint16_t rgb565(std::uint8_t grey) {
  // round(grey * 31 / 255) and round(grey * 63 / 255) by shifts, exact for all 256 values.
  const auto five = static_cast<unsigned>((grey * 249 + 1014) >> 11);
  const auto six = static_cast<unsigned>((grey * 253 + 505) >> 10);
  return static_cast<std::uint16_t>(five << 11 | six << 5 | five);
}

struct DrmDisplayConfig {
  std::optional<std::string>
      card;  // "/dev/dri/card1" or a driver's name ("vc4"); if unset the first with a connected output
  std::optional<std::string> connector;  // "HDMI-A-1"; if unset the first that is connected
  Pixels width{1920};
  Pixels height{1080};
  double refresh_hz = 60.0;  // a mode's refresh may differ by half a hertz

  using Format = PixelFormat;
  Format format = Format::Xrgb8888;
  // The number of buffers for masks; black has its own. With 3, a buffer that has left the screen is not
  // written until the next one has left it too, for drivers that still read a buffer after they reported the
  // flip away from it.
  int buffers = 2;  // 2 or 3

  bool legacy = false;            // use the legacy calls even if the driver supports atomic calls
  bool ignore_edid_size = false;  // ignore the picture size that the display reports, because it is wrong
};

}  // namespace contourd
