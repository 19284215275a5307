// Thumbnails: part of a mask, made small enough for a page. Thread-safe (no shared state).
#pragma once

#include <cstdint>

#include "core/mask/mask.hpp"

namespace contourd {

// Returns the box, reduced to at most `longest` pixels on each side, never enlarged. Each pixel is the mean
// of its source pixels, but at least a sixth of the light if any of them is lit: a strut must not vanish.
// Uses no memory besides the picture's. REQUIRES: a box with pixels, all of them the mask's; longest > 0.
[[nodiscard]] Mask make_thumbnail(const Mask& mask, const PixelBox& box, Pixels longest);

}  // namespace contourd
