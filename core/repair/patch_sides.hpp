// Finds which side of a mesh's patches is outside, and which patches are walls within a solid. Pure,
// thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"
#include "core/repair/patch_balance.hpp"

namespace contourd {

struct PatchSides {
  std::vector<std::int32_t> windings;  // by patch: how often it counts, as the patch is turned
  std::vector<bool> as_filed;          // by patch: stays as it is in the file
  std::vector<bool> inner_walls;       // by patch: lies within a solid and encloses nothing
};

// Finds the sides of all groups of patches. A group that lies within no other is turned outwards. A group
// within a solid is turned as most of its facets are, and inwards, as a cavity, if the facets have no clear
// majority. A group that the file has twice counts twice only if it is a hole in two solids.
[[nodiscard]] PatchSides find_sides(std::span<const Facet> facets, const FacetPatches& mesh,
                                    const PatchGroups& groups);

}  // namespace contourd
