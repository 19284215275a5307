// A mask: the light of one exposure, one grey value a pixel (0 dark, 255 fully lit), row 0 at the top. A
// value; thread-safe as any value is.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/units.hpp"

namespace contourd {

// A box of pixels: columns [left, right) of the rows [top, bottom).
struct PixelBox {
  std::int32_t left = 0, top = 0, right = 0, bottom = 0;

  bool operator==(const PixelBox&) const = default;
};

class Mask {
 public:
  Mask() = default;
  // Makes a dark mask. Throws std::invalid_argument unless both sides are 1 to 16384 pixels.
  Mask(Pixels width, Pixels height);

  [[nodiscard]] Pixels width() const { return width_; }
  [[nodiscard]] Pixels height() const { return height_; }

  // Returns one row's pixels, left to right. REQUIRES: 0 <= y < height.
  [[nodiscard]] std::span<std::uint8_t> row(std::int32_t y);
  [[nodiscard]] std::span<const std::uint8_t> row(std::int32_t y) const;
  // Returns all rows from the top, without padding between them.
  [[nodiscard]] std::span<const std::uint8_t> pixels() const { return pixels_; }

  // Returns the number of pixels that are not dark.
  [[nodiscard]] std::int64_t lit_pixels() const;
  // Returns the sum of all grey values divided by 255: the exposed area in pixels.
  [[nodiscard]] double lit_area() const;

  bool operator==(const Mask&) const = default;

 private:
  Pixels width_{};
  Pixels height_{};
  std::vector<std::uint8_t> pixels_;
};

}  // namespace contourd
