// A check that a model's mesh is sound, in one pass over its facets. Pure, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

// True if every edge is walked as often in one direction as in the other, and no two facets have the same
// vertices, in either orientation. The check compares hashes, so it can be wrong by chance: true for one
// cracked model in two thousand million, false for one sound model of a million facets in a thousand. Takes
// some 15 ns a facet, and 6 to 12 bytes a facet while it runs.
[[nodiscard]] bool is_sound(std::span<const Facet> facets);

}  // namespace contourd
