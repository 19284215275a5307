// A slow reference for a model's masks: the region where the facets' winding number is not 0, along 64 lines
// a pixel, exact along each line. Shares no code with the core. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd::reference {

// A picture at true scale: (center_x, center_y) lies in its middle; y points up in the model and down in the
// picture.
struct Picture {
  int width, height;
  double pixels_per_mm, center_x, center_y;
};

// Returns the covered share of each pixel, row by row, just above z. REQUIRES: a closed model.
[[nodiscard]] std::vector<double> coverage_at(std::span<const Facet> facets, double z,
                                              const Picture& picture);

// Returns intersection over union, by coverage; 1 if both are empty. `mask` is in 255ths.
[[nodiscard]] double overlap_of(std::span<const double> coverage, std::span<const std::uint8_t> mask);

}  // namespace contourd::reference
