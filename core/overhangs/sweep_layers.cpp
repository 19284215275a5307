#include "core/overhangs/sweep_layers.hpp"

#include <algorithm>

namespace contourd {

SweepLayers::SweepLayers(std::span<const Nanometers> thicknesses, Millimeters top) : tops_(1) {
  if (thicknesses.empty()) {
    for (Nanometers middle = kDefaultSweptLayer / 2; to_millimeters(middle) < top;
         middle += kDefaultSweptLayer)
      tops_.push_back(middle + kDefaultSweptLayer / 2);
    return;
  }
  const std::size_t together = (thicknesses.size() + kMostLayers - 1) / kMostLayers;
  Nanometers height{};
  for (std::size_t i = 0; i < thicknesses.size(); ++i) {
    height += thicknesses[i];
    if ((i + 1) % together == 0 || i + 1 == thicknesses.size()) tops_.push_back(height);
  }
}

Nanometers SweepLayers::step() const {
  constexpr Nanometers kThinnest{20'000};
  Nanometers thinnest = kDefaultSweptLayer;
  for (std::int32_t layer = 1; layer <= count(); ++layer)
    thinnest = std::min(thinnest, thickness_of(layer));
  return std::max(thinnest, kThinnest);
}

}  // namespace contourd
