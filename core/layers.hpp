// Uniform layers of a model: how many, and where each is cut. Values; thread-safe.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/units.hpp"

namespace contourd {

// Layers of one thickness, counted from 0 at the bottom.
struct LayerStack {
  Nanometers thickness{};
  std::int32_t count = 0;

  // Each layer is cut at its middle. Above the model's lowest point.
  [[nodiscard]] Nanometers middle_of(std::int32_t layer) const {
    return Nanometers{thickness.count() * layer + thickness.count() / 2};
  }
};

// As many layers as it takes to reach the model's top; a rest below a hundredth of a layer is rounding noise
// of the file's coordinates, not a layer. Nothing when that is more layers than a print can have (2^31).
// REQUIRES: thickness > 0.
[[nodiscard]] inline std::optional<LayerStack> layers_for(Millimeters model_height, Nanometers thickness) {
  constexpr double kRoundingNoise = 0.01;
  const double layers = std::ceil(model_height.count() / to_millimeters(thickness).count() - kRoundingNoise);
  if (!(layers < std::numeric_limits<std::int32_t>::max())) return std::nullopt;
  return LayerStack{thickness, static_cast<std::int32_t>(std::fmax(layers, 0.0))};
}

// Where layers of these thicknesses, stacked from the plate up, are cut: each at its middle.
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
