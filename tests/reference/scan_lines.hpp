// What a model's masks should be, worked out the slow way: where its facets wind around other than 0 times,
// along 64 lines a pixel, exact along each. Shares no code with the core. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd::reference {

// True scale: (center_x, center_y) lies in the picture's middle, y points up in the model and down in it.
struct Picture {
  int width, height;
  double pixels_per_mm, center_x, center_y;
};

// The covered part of each pixel, row by row, just above z. REQUIRES: a closed model.
[[nodiscard]] std::vector<double> coverage_at(std::span<const Facet> facets, double z,
                                              const Picture& picture);

// Their intersection over their union, by coverage; 1 where both are empty. `mask` in 255ths.
[[nodiscard]] double overlap_of(std::span<const double> coverage, std::span<const std::uint8_t> mask);

}  // namespace contourd::reference
