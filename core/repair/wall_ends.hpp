// Which open patches within a solid are walls that end there, and which are parts of a surface that goes on
// in other patches. Pure, thread-safe.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

// Leaves of `walls` (by patch) those that end somewhere, together with the walls beside them. A surface whose
// facets miss each other by little is many open patches: of a cavity's none ends anywhere, and those of a
// solid that reaches into another one go on outside. Takes some microseconds a boundary edge.
void keep_walls_that_end(std::span<const Facet> facets, const FacetPatches& mesh, std::vector<bool>& walls);

}  // namespace contourd
