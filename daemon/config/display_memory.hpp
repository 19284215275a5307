// Estimates the memory that contourd uses without a model. Pure functions, thread-safe.
#pragma once

#include <cstdint>

#include "core/geometry/units.hpp"

namespace contourd {

// Memory of the idle program, with its threads and connections.
inline constexpr std::uint64_t kProgramBytes = 10'000'000;

// Returns the memory for the masks of a print and of its analysis, the buffers that they are painted from, a
// uniformity mask, the preview, the report's pictures of layers (which need no mask of their own), and a copy
// of the mask with its PNG for clients.
[[nodiscard]] constexpr std::uint64_t memory_for_display(Pixels width, Pixels height) {
  constexpr std::uint64_t kBytesAPixel = 12, kOthers = 12'000'000;
  return kOthers + kBytesAPixel * static_cast<std::uint64_t>(width.count()) *
                       static_cast<std::uint64_t>(height.count());
}

}  // namespace contourd
