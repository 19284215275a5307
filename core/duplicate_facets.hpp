// Where a model's file has facets twice. Pure, thread-safe.
#pragma once

#include <span>
#include <vector>

#include "core/facet.hpp"

namespace contourd {

// The heights (low <= z < high) of facets that have the same vertices as another one in the same direction of
// turning, wherever they begin: apart from each other and ascending. May have one of a facet that is there
// once, by chance: about once in a thousand models of a million facets. Takes some 15 ns a facet, and 6 to 12
// bytes a facet while it looks.
[[nodiscard]] std::vector<HeightRange> heights_of_duplicates(std::span<const Facet> facets);

}  // namespace contourd
