// What contourd takes of memory before there is a model. Pure functions, thread-safe.
#pragma once

#include <cstdint>

#include "core/geometry/units.hpp"

namespace contourd {

// The program, with its threads and connections, when it has nothing to do.
inline constexpr std::uint64_t kProgramBytes = 10'000'000;

// Masks of the print and of its analysis, what they are painted from, a uniformity mask, the preview and the
// report's pictures of layers, which take no mask of their own; a copy of the mask for whoever asks, and its
// PNG.
[[nodiscard]] constexpr std::uint64_t memory_for_display(Pixels width, Pixels height) {
  constexpr std::uint64_t kBytesAPixel = 12, kOthers = 12'000'000;
  return kOthers + kBytesAPixel * static_cast<std::uint64_t>(width.count()) *
                       static_cast<std::uint64_t>(height.count());
}

}  // namespace contourd
