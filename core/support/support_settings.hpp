// A resin's support settings. The defaults are PrusaSlicer's where it has the same setting (its
// PrintConfig.cpp). A value; thread-safe as any value is.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/geometry/units.hpp"

namespace contourd {

// Returns the largest gap above the plate that the long exposure of the bottom layers closes: as high as the
// bottom layers, but at most 0.3 mm, because no bottom exposure cures deeper.
[[nodiscard]] inline Millimeters closed_gap(std::int32_t bottom_layers, Nanometers layer) {
  return std::min(to_millimeters(layer) * bottom_layers, Millimeters{0.3});
}

struct SupportSettings {
  Millimeters tip_diameter{0.4};     // at the point where a support meets the model
  Millimeters tip_depth{0.2};        // how far the tip reaches into the model
  Millimeters tip_length{1.0};       // length of the cone between the tip and the branch
  Millimeters pillar_diameter{1.0};  // next to the tip; a branch gets thicker with load and length
  Millimeters foot_diameter{4.0};    // on the plate
  Millimeters foot_height{1.0};
  Millimeters clearance{0.5};   // between a branch and the model
  Millimeters lift{5.0};        // how high a model is lifted that does not stand by itself
  Millimeters bridge{1.5};      // how far a layer may reach out beyond the material that carries it
  Millimeters spacing{3.2};     // between contacts below a horizontal surface
  double tip_holds_mm2 = 11.1;  // area of a layer that one tip holds when the layer is peeled off

  // Largest gap above the plate that the bottom layers close. The print sets it, not the resin.
  Millimeters closed_gap{0.25};

  bool operator==(const SupportSettings&) const = default;
};

}  // namespace contourd
