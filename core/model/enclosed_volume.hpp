// The volume that a model's facets enclose. Pure function, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

struct EnclosedVolume {
  double mm3 = 0;  // negative if the facets face inwards
  // How much mm3 depends on the point that it is calculated from, over all points of the model's bounds; 0,
  // but for rounding, if the facets close.
  double uncertainty_mm3 = 0;

  // True if the volume is negative even when gaps between the facets are taken into account.
  [[nodiscard]] bool inside_out() const { return mm3 < -uncertainty_mm3; }
};

// Adds up the tetrahedra of all facets from a point of the model, which keeps the digits of small models far
// from (0, 0, 0).
[[nodiscard]] EnclosedVolume enclosed_volume(std::span<const Facet> facets, const Bounds& bounds);

}  // namespace contourd
