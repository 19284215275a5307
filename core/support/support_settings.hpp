// How what hangs in the air is held: the figures of a resin's supports. By default PrusaSlicer's, where it
// has the same (its PrintConfig.cpp). A value; thread-safe as any value is.
#pragma once

#include "core/geometry/units.hpp"

namespace contourd {

struct SupportSettings {
  Millimeters tip_diameter{0.4};     // where a support meets the model
  Millimeters tip_depth{0.2};        // how far it reaches into the model
  Millimeters tip_length{1.0};       // of the cone between the tip and the branch
  Millimeters pillar_diameter{1.0};  // of a branch at its tip; it gets thicker with load and length
  Millimeters foot_diameter{4.0};    // on the plate
  Millimeters foot_height{1.0};
  Millimeters clearance{0.5};   // to the model, all along a branch
  Millimeters lift{5.0};        // how high a model stands that does not stand by itself
  Millimeters bridge{1.5};      // how far a layer may reach out beyond what carries it
  Millimeters spacing{3.2};     // between contacts beneath a level surface
  double tip_holds_mm2 = 11.1;  // of a layer's area, when it is peeled off

  bool operator==(const SupportSettings&) const = default;
};

}  // namespace contourd
