// Facets that enclose nothing: slivers thinner than any pixel, and facets that cancel each other. They print
// nothing, but would count in the model's size and position. Pure functions, thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"

namespace contourd {

// Returns by facet whether it belongs to a group of facets that is joined to no other facet, encloses nothing
// and reaches out of the box around all other facets; nullopt if there is no such facet. Facets are joined if
// their vertices are at most some 0.02 mm apart. A group encloses nothing if its facets, apart from those
// that cancel each other, are thinner than 0.02 mm even side by side, and than 1/500 of the model, because a
// file's unit may be a metre. Sound models take some 20 nanoseconds a facet and at most 2 MB. Others take
// half a microsecond and 100 bytes for each facet that may be joined to one that is in doubt. REQUIRES:
// finite coordinates, fewer than 2^30 facets.
[[nodiscard]] std::optional<std::vector<bool>> void_facets(std::span<const Facet> facets);

}  // namespace contourd
