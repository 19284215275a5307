// The area that is missing from an open patch. Pure function, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

// Returns the area, in square millimetres, of the fans that close each loop of these boundary edges from the
// loop's middle.
[[nodiscard]] double area_to_close(std::span<const Facet> facets, std::span<const Face> faces,
                                   std::span<const BoundaryEdge> boundary_edges);

}  // namespace contourd
