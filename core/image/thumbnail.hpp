// Part of a mask, made small enough for a page. Thread-safe (no shared state).
#pragma once

#include <cstdint>

#include "core/mask/mask.hpp"

namespace contourd {

// Columns [left, right) of the rows [top, bottom).
struct PixelBox {
  std::int32_t left = 0, top = 0, right = 0, bottom = 0;

  bool operator==(const PixelBox&) const = default;
};

// What is in the box at most `longest` pixels wide and high, never enlarged. A pixel is the mean of those
// that it stands for, but no darker than a sixth of the light where any of them is lit: a strut must not
// vanish. Takes no memory but the picture's. REQUIRES: a box with pixels, all of them the mask's; longest >
// 0.
[[nodiscard]] Mask make_thumbnail(const Mask& mask, const PixelBox& box, Pixels longest);

}  // namespace contourd
