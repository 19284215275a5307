// Whether a model's mesh is sound, in one pass over its facets. Pure, thread-safe.
#pragma once

#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

// True when every edge is walked as often in one direction as in the other, and no facet has the same
// vertices as another, however they are turned: as a rule. By chance it is true of one cracked model in two
// thousand million, and false of one sound model of a million facets in a thousand. Takes some 15 ns a facet,
// and 6 to 12 bytes a facet while it looks.
[[nodiscard]] bool is_sound(std::span<const Facet> facets);

}  // namespace contourd
