// Meshes of blocks that stand on and beside each other. Values and pure functions; thread-safe.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// An axis-aligned box.
struct Block {
  Vertex low, high;
};

// Returns the surface of the blocks' union: closed, facing outwards, without a facet inside. Blocks that meet
// along an edge or in a corner only give an edge of four facets there. Takes time and memory by the product
// of the numbers of different coordinates along the three axes. REQUIRES: blocks with a volume.
[[nodiscard]] std::vector<Facet> joined(std::span<const Block> blocks);

}  // namespace contourd
