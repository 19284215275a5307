// Boxes around facets. Pure functions, thread-safe.
#pragma once

#include <algorithm>
#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

[[nodiscard]] inline Bounds box_around(const Facet& facet) {
  return bounds_of(std::span(&facet, 1));
}

[[nodiscard]] inline bool contains(const Bounds& outer, const Bounds& inner) {
  return outer.min_x <= inner.min_x && outer.min_y <= inner.min_y && outer.min_z <= inner.min_z &&
         outer.max_x >= inner.max_x && outer.max_y >= inner.max_y && outer.max_z >= inner.max_z;
}

// Extends the first box so that it contains the other one.
inline void extend(Bounds& bounds, const Bounds& by) {
  bounds = {std::min(bounds.min_x, by.min_x), std::min(bounds.min_y, by.min_y),
            std::min(bounds.min_z, by.min_z), std::max(bounds.max_x, by.max_x),
            std::max(bounds.max_y, by.max_y), std::max(bounds.max_z, by.max_z)};
}

}  // namespace contourd
