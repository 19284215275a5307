// Repairs a mesh whose facets disagree with each other before it is sliced: facets that are turned against
// their neighbours, that are there more than once, or that are walls within a solid. Pure, thread-safe.
//
// Repairs only turn or drop facets: no vertex moves, no facet is added. Facets that share an edge with one
// other facet are turned alike; where more meet, they are turned so that each edge is walked as often one way
// as the other. Gaps are left to ContourLinker, which closes them section by section.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// The number of facets repaired, by kind of repair.
struct MeshRepairs {
  std::uint64_t turned = 0;       // turned round
  std::uint64_t doubled = 0;      // dropped: a duplicate, turned alike
  std::uint64_t reversed = 0;     // dropped: a duplicate, turned the other way
  std::uint64_t inner_walls = 0;  // dropped: part of a one-sided wall within a solid

  // True if a repair guessed what the file means: more than dropping a duplicate that is turned alike.
  [[nodiscard]] bool has_guesses() const { return turned > 0 || reversed > 0 || inner_walls > 0; }
  bool operator==(const MeshRepairs&) const = default;
};

// Repairs the facets in place and returns what was repaired. Facets that need no repair stay as they are, and
// the remaining facets keep their order. Takes time and memory in proportion to the number of facets: a
// microsecond each, some fifteen if most edges have more than two facets, and 60 bytes. REQUIRES: finite
// coordinates, fewer than 2^30 facets.
MeshRepairs repair_mesh(std::vector<Facet>& facets);

}  // namespace contourd
