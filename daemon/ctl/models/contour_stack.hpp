// The stacked contours of a print (thesis, figures 4.1 to 4.7), small enough for a page: every n-th layer,
// without points that a picture cannot show, as 16-bit numbers. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"

namespace contourd::ctl {

struct ContourStack {
  std::vector<std::int32_t> layers;  // indices of the included layers, from 0
  // Little-endian words of 16 bits: for each loop its place in `layers`, its number of points (low, high),
  // then x and y of each point. A word w stands for the millimetre min + w / 65535 * size, on the plate.
  std::vector<std::uint8_t> words;
  std::vector<std::uint8_t> support_words;  // loops of supports, in this format
  double min_x_mm = 0, min_y_mm = 0;
  double size_mm = 0;  // along x and y alike
};

struct StackedPrint {
  const ContourEngine& engine;
  const SectionSource* supports = nullptr;  // if there are any
};
struct StackLimits {
  std::int32_t most_layers = 0;
  std::size_t most_points = 0;
};

// Stacks the contours of the layers that are cut at these heights, within the limits.
[[nodiscard]] ContourStack stack_contours(const StackedPrint& print, const DisplayGeometry& display,
                                          std::span<const Nanometers> middles, const StackLimits& limits);

// Simplifies a closed polygon (Douglas and Peucker): removes points within `tolerance` of the line between
// the remaining neighbours.
[[nodiscard]] std::vector<Point> simplified(std::span<const Point> polygon, double tolerance);

}  // namespace contourd::ctl
