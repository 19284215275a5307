// Decides how often each patch of a mesh counts, and which way it is turned, so that the edges at which
// patches meet are walked as often one way as the other. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "core/repair/facet_patches.hpp"

namespace contourd {

struct PatchGroups {
  struct Group {
    std::uint32_t first_patch = 0;  // index in `members`
    std::uint32_t patches = 0;
    bool inconsistent = false;  // the file contradicts itself here
    bool double_sided = false;  // each of its facets is there in both directions
  };
  // by patch; 1 if not orientable, because such a patch stays as it is in the file
  std::vector<std::int32_t> windings;
  std::vector<Group> groups;           // patches that are connected by junctions
  std::vector<std::uint32_t> members;  // patches, by group
};

// Chooses the windings. The file decides where it can: the majority of a patch's facets says how often the
// patch counts and which way it is turned, as long as the junctions agree. Otherwise the windings are chosen
// that make them agree and change the least area.
[[nodiscard]] PatchGroups balance_patches(const FacetPatches& mesh);

}  // namespace contourd
