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

// True if models whose highest top is at `top` above the plate have a section at a height: below the top.
// Tops are sums of two lengths, whose last digits are not sure.
[[nodiscard]] inline bool is_below_top(Nanometers height, Millimeters top) {
  constexpr double kLastDigits = 4 * std::numeric_limits<double>::epsilon();
  return to_millimeters(height) < top * (1 - kLastDigits);
}

// Returns the layers that have something of a model whose highest top is at `top` above the plate. What
// remains above the last whole layer is one more layer if it is higher than that layer's middle, where it is
// cut: the mask of a lower remainder would be dark. Throws TooManyLayers. REQUIRES: is_layer(thickness).
[[nodiscard]] inline LayerStack layers_for(Millimeters top, Nanometers thickness) {
  expects(is_layer(thickness), "a layer's thickness is positive and at most kThickestLayer");
  constexpr double kLargestExactCount = 1LL << 53;
  const double layers = std::ceil(top.count() / to_millimeters(thickness).count());
  if (!(layers <= kLargestExactCount)) throw TooManyLayers();
  // One more may be a remainder.
  if (layers > kMaxLayers + 1) throw TooManyLayers(static_cast<std::int64_t>(layers));
  LayerStack stack{thickness, static_cast<std::int32_t>(std::fmax(layers, 0.0))};
  if (stack.count > 0 && !is_below_top(stack.middle_of(stack.count - 1), top)) --stack.count;
  if (stack.count > kMaxLayers) throw TooManyLayers(stack.count);
  return stack;
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
