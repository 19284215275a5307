// Uniform layers of a model: their number, and the height at which each is cut. Values; thread-safe.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// Layers of one thickness, counted from 0 at the bottom.
struct LayerStack {
  Nanometers thickness{};
  std::int32_t count = 0;

  // Returns the height above the plate at which a layer is cut: its middle.
  [[nodiscard]] Nanometers middle_of(std::int32_t layer) const {
    return Nanometers{thickness.count() * layer + thickness.count() / 2};
  }
};

// The most layers of a print: 10 m of the thinnest, a thousand times what printers print. Lists of layers,
// with all data of each, stay below a gigabyte, and counting them takes seconds.
inline constexpr std::int32_t kMaxLayers = 10'000'000;
// The thickest layer; the limit keeps the nanometres of a print's height within 64 bits.
inline constexpr Nanometers kThickestLayer{1'000'000'000};
static_assert(kThickestLayer.count() <= std::numeric_limits<std::int64_t>::max() / kMaxLayers);

[[nodiscard]] constexpr bool is_layer(Nanometers thickness) {
  return Nanometers{} < thickness && thickness <= kThickestLayer;
}

// Thrown if a model has more layers than kMaxLayers. what() is a sentence with the figures.
class TooManyLayers : public std::runtime_error {
 public:
  // For more layers than can be counted.
  TooManyLayers() : std::runtime_error("the model has more than " + std::to_string(kMaxLayers) + " layers") {}
  explicit TooManyLayers(std::int64_t layers)
      : std::runtime_error("the model has " + std::to_string(layers) + " layers, at most " +
                           std::to_string(kMaxLayers) + " can be printed") {}
};

// Returns as many layers as it takes to reach the highest model's top above the plate. A remainder below a
// hundredth of a layer is rounding noise of the file's coordinates and is no layer. Throws TooManyLayers.
// REQUIRES: is_layer(thickness).
[[nodiscard]] inline LayerStack layers_for(Millimeters top, Nanometers thickness) {
  expects(is_layer(thickness), "a layer's thickness is positive and at most kThickestLayer");
  constexpr double kRoundingNoise = 0.01;
  constexpr double kLargestExactCount = 1LL << 53;
  const double layers = std::ceil(top.count() / to_millimeters(thickness).count() - kRoundingNoise);
  if (!(layers <= kLargestExactCount)) throw TooManyLayers();
  if (layers > kMaxLayers) throw TooManyLayers(static_cast<std::int64_t>(layers));
  return LayerStack{thickness, static_cast<std::int32_t>(std::fmax(layers, 0.0))};
}

// Returns the heights at which layers of these thicknesses, stacked from the plate up, are cut: each at its
// middle.
[[nodiscard]] inline std::vector<Nanometers> middles_of(std::span<const Nanometers> thicknesses) {
  std::vector<Nanometers> middles;
  middles.reserve(thicknesses.size());
  Nanometers bottom{};
  for (const Nanometers thickness : thicknesses) {
    middles.push_back(bottom + thickness / 2);
    bottom += thickness;
  }
  return middles;
}

}  // namespace contourd
