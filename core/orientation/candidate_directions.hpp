// Which directions of a model are tried as the one that points up. Pure function, thread-safe; the same on
// every machine.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"

namespace contourd {

// As drawn, (0, 0, 1), comes first; then the other axes both ways; then what puts one of the model's largest
// flat faces on the plate, the largest first; then so many that are spread evenly over all directions. Each
// of length 1, and at least 3 degrees from those before it.
inline constexpr std::size_t kMostFaceDirections = 16, kSpreadDirections = 200;
inline constexpr std::size_t kMostDirections = 6 + kMostFaceDirections + kSpreadDirections;
[[nodiscard]] std::vector<Direction> candidate_directions(std::span<const Facet> facets);

}  // namespace contourd
