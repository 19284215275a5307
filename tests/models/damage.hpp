// Typical defects of meshes, applied to good ones: the same damage for the same seed on every machine.
// Thread-safe (no shared state).
#pragma once

#include "tests/models/dice.hpp"
#include "tests/models/models.hpp"

namespace contourd::models {

// Returns facets anywhere, with their corners up to `reach_mm` from the origin.
[[nodiscard]] Facets soup(std::size_t count, double reach_mm, Dice& dice);

// Moves each corner of each facet on its own by up to `reach_mm`, which opens cracks along every side.
void shake_corners(Facets& facets, double reach_mm, Dice& dice);

// Moves each vertex by up to `reach_mm`, the same in all facets: the mesh stays closed.
void shake_vertices(Facets& facets, double reach_mm, Dice& dice);

// Removes a share of the facets, at least one, and returns them.
Facets drop_facets(Facets& facets, double share, Dice& dice);

// Turns each facet inwards, by swapping two corners, with probability `share`.
void turn_facets(Facets& facets, double share, Dice& dice);

// Appends copies of a share of the facets.
void double_facets(Facets& facets, double share, Dice& dice);

// Appends reversed copies of a share of the facets.
void double_facets_reversed(Facets& facets, double share, Dice& dice);

// Splits one side of a share of the facets, at least one, but not of the neighbour (T-junctions); the new
// vertex lies up to `reach_mm` from the side's middle.
void split_sides(Facets& facets, double share, double reach_mm, Dice& dice);

}  // namespace contourd::models
