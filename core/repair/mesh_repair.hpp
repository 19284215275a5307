// Repairs a mesh whose facets disagree with each other, before it is cut: where facets are turned against
// their neighbours, are there more than once, or are walls within a solid. Pure, thread-safe.
//
// What needs no guess about the surface is done: no vertex moves, no facet is added. Facets that share an
// edge with one other are turned alike; where more meet, so that each edge is walked as often one way as the
// other. What stays open is left to ContourLinker, section by section.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// In facets.
struct MeshRepairs {
  std::uint64_t turned = 0;       // turned round
  std::uint64_t doubled = 0;      // left out: there once more, turned alike
  std::uint64_t reversed = 0;     // left out: there once more, turned the other way
  std::uint64_t inner_walls = 0;  // left out: a wall of one side within a solid

  // Whether what is printed is more than what the file says. What is there twice is no guess.
  [[nodiscard]] bool has_guesses() const { return turned > 0 || reversed > 0 || inner_walls > 0; }
  bool operator==(const MeshRepairs&) const = default;
};

// Facets that need no repairing stay as they are, and all that stay keep their order. Takes time and memory
// in proportion to the number of facets: a microsecond each, some fifteen where more than two share most
// edges, and 60 bytes. REQUIRES: finite coordinates, fewer than 2^30 facets.
MeshRepairs repair_mesh(std::vector<Facet>& facets);

}  // namespace contourd
