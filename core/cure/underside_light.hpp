// The light that a solid's lowest layers get so that its underside cures at its drawn height. Pure function;
// thread-safe.
//
// Resin at the underside gets light with the first layer above it and with all later ones, more than it needs
// to solidify, so that the solid grows downwards (see CuredLayers). Less light in the lowest layers mends
// this: from above, each layer gets all its light as long as the dose at the underside stays below Ec, the
// next one below gets a share that makes the dose Ec, and the layers below that one none. They are solidified
// by the light that passes through the layers above (US patents 5,597,520 and 6,366,825, both expired).
#pragma once

#include <cstddef>
#include <span>

namespace contourd {

// Layers are counted from the solid's first one.
struct UndersideLight {
  std::size_t dark = 0;  // layers without light
  // Light of the layer above them, 0 to 1. All layers above that one get all their light.
  double next_share = 1;

  bool operator==(const UndersideLight&) const = default;
};

// The loss of dose of liquid resin at a peel.
struct PeelLoss {
  double kept = 1;  // share that is kept, 0 to 1
  double lost = 0;  // subtracted from the kept dose, over Ec; not negative
};

// Returns the light of a solid's lowest layers. `doses`: of each layer, as far up as they count, the dose
// that it gives to the underside, over Ec. At most `most_dimmed` layers get less than all their light; if
// these are too few, they get none. REQUIRES: doses that are not negative; most_dimmed < doses.size().
[[nodiscard]] UndersideLight underside_light(std::span<const double> doses, const PeelLoss& loss,
                                             std::size_t most_dimmed);

}  // namespace contourd
