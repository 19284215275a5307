// The directions of a model that are tried as the one that points up. Pure function, thread-safe; the same
// directions on every machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"

namespace contourd {

// Limits on the directions that put a face on the plate, on the evenly spread ones, and on all together.
inline constexpr std::size_t kMostFaceDirections = 16, kSpreadDirections = 200;
inline constexpr std::size_t kMostDirections = 6 + kMostFaceDirections + kSpreadDirections;
// Returns the directions to try, each of length 1 and at least 3 degrees from the earlier ones: first (0, 0,
// 1), as drawn; then the other axes both ways; then the directions that put one of the model's largest flat
// faces on the plate, largest first; then directions that are spread evenly over the sphere.
[[nodiscard]] std::vector<Direction> candidate_directions(std::span<const Facet> facets);

}  // namespace contourd
