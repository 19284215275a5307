// Pixel formats of a scanned-out buffer, and grey values in these formats. Values and pure functions.
#pragma once

#include <cstddef>
#include <cstdint>

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

}  // namespace contourd
