// Tells apart open patches within a solid that are walls ending there, and those that are parts of a surface
// that continues in other patches. Pure, thread-safe.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

// Keeps in `walls` (by patch) the walls that end somewhere, together with the walls beside them. A surface
// whose facets miss each other by little consists of many open patches: none of a cavity's patches ends
// anywhere, and those of a solid that reaches into another one continue outside. Takes some microseconds for
// each boundary edge.
void keep_walls_that_end(std::span<const Facet> facets, const FacetPatches& mesh, std::vector<bool>& walls);

}  // namespace contourd
