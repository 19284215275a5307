// How much is missing of an open patch. Pure function, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

// The area, in square millimetres, of fans that close each loop of these rims from its middle.
[[nodiscard]] double area_to_close(std::span<const Facet> facets, std::span<const Face> faces,
                                   std::span<const Rim> rims);

}  // namespace contourd
