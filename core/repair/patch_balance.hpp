// How often each patch of a mesh counts, and turned which way, so that the edges at which patches meet are
// walked as often one way as the other. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "core/repair/facet_patches.hpp"

namespace contourd {

struct PatchGroups {
  struct Group {
    std::uint32_t first_patch = 0;  // in `members`
    std::uint32_t patches = 0;
    bool inconsistent = false;  // the file disagrees with itself
    bool double_sided = false;  // each of its facets is there in both directions
  };
  std::vector<std::int32_t> windings;  // by patch; of those not orientable 1: the file is left as it is
  std::vector<Group> groups;           // patches that meet, over whatever edges
  std::vector<std::uint32_t> members;  // patches, by group
};

// The file decides where it can: most of a patch's facets how often it counts and which way it is turned, as
// long as the junctions agree; else what makes them agree and changes the least area.
[[nodiscard]] PatchGroups balance_patches(const FacetPatches& mesh);

}  // namespace contourd
