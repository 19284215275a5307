// Triangles of a polygon in space, by cutting ears. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// Appends the triangles of a polygon, which may be concave: two fewer than it has corners, in its direction,
// and over its corners only. A polygon that crosses itself gets triangles, too, but no particular ones.
// `tests` is reduced by the number of corners that had to be compared, at most the cube of their number.
// Returns false, and appends only a part, if it would become negative. REQUIRES: 3 corners.
[[nodiscard]] bool add_triangles(std::span<const Vertex> corners, std::vector<Facet>& facets,
                                 std::int64_t& tests);

}  // namespace contourd
