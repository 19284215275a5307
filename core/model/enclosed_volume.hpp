// What a model's facets enclose. Pure function, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

struct EnclosedVolume {
  double mm3 = 0;  // negative when the facets face inwards
  // By how much that depends on where it is reckoned from, over all points of the model's bounds; 0, but for
  // rounding, when the facets close.
  double uncertainty_mm3 = 0;

  // Negative, also if the facets' gaps are taken into account.
  [[nodiscard]] bool inside_out() const { return mm3 < -uncertainty_mm3; }
};

// Every facet's tetrahedron from a point of the model, which keeps the digits of small models far from (0, 0,
// 0).
[[nodiscard]] EnclosedVolume enclosed_volume(std::span<const Facet> facets, const Bounds& bounds);

}  // namespace contourd
