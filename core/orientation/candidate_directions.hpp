// Finds the directions of a model that are worth trying as the one that points up. Pure function,
// thread-safe. Deterministic.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"

namespace contourd {

// The direction that points up in a model as drawn.
inline constexpr Direction kAsDrawn{0, 0, 1};

// Limits on the directions that put a face on the plate, on the evenly spread ones, and on all together.
inline constexpr std::size_t kMostFaceDirections = 32, kSpreadDirections = 200;
inline constexpr std::size_t kMostDirections = 6 + kMostFaceDirections + kSpreadDirections;

// Returns the directions that put one of the model's largest flat faces on the plate, largest first, at most
// kMostFaceDirections: those of candidate_directions().
[[nodiscard]] std::vector<Direction> face_directions(std::span<const Facet> facets);

// Returns the directions to try, each of length 1: first kAsDrawn; then the directions that put
// one of the model's largest flat faces on the plate, largest first; then the other axes both ways; then
// directions that are spread evenly over the sphere. Each is at least 3 degrees from the earlier ones, except
// that the direction of a face only has to differ from (0, 0, 1): a model that is drawn with its base nearly
// level can be put flat on the plate.
[[nodiscard]] std::vector<Direction> candidate_directions(std::span<const Facet> facets);

}  // namespace contourd
