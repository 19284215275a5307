// The area that an open patch lacks. Pure function, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

// The area, in square millimetres, of fans that close each loop of these boundary edges from its middle.
[[nodiscard]] double area_to_close(std::span<const Facet> facets, std::span<const Face> faces,
                                   std::span<const BoundaryEdge> boundary_edges);

}  // namespace contourd
