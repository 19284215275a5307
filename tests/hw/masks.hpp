// Masks for the tests of displays and pictures. Pure functions.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/mask/mask.hpp"

namespace contourd::testing {

inline Mask mask_of(std::int64_t width, std::int64_t height, int grey) {
  Mask mask(Pixels{static_cast<std::int32_t>(width)}, Pixels{static_cast<std::int32_t>(height)});
  for (std::int32_t y = 0; y < height; ++y)
    std::ranges::fill(mask.row(y), static_cast<std::uint8_t>(grey));
  return mask;
}

// Returns a mask of random greys that depend only on the seed.
inline Mask noise(std::int64_t width, std::int64_t height, std::uint64_t seed = 1) {
  Mask mask = mask_of(width, height, 0);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::uint8_t& grey : mask.row(y)) {
      seed = seed * 6364136223846793005U + 1442695040888963407U;
      grey = static_cast<std::uint8_t>(seed >> 56);
    }
  }
  return mask;
}

}  // namespace contourd::testing
