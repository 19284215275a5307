// Gives a mesh's vertices numbers. Pure functions, thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

using Corners = std::array<std::uint32_t, 3>;  // a facet's vertices, by number

// Vertices have the same number when their coordinates are equal, bit for bit (-0 and 0 alike); numbers begin
// with 0 and leave none out. Takes 40 bytes a facet while it counts, at most.
[[nodiscard]] std::vector<Corners> number_vertices(std::span<const Facet> facets);

// Whether two vertices are the same.
[[nodiscard]] inline bool is_degenerate(const Corners& c) {
  return c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
}

}  // namespace contourd
