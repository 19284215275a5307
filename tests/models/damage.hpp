// What goes wrong with meshes on their way, done to good ones: the same damage from the same seed on every
// machine. Thread-safe (no shared state).
#pragma once

#include <cstdint>

#include "tests/models/models.hpp"

namespace contourd::models {

// Numbers that look random (SplitMix64), the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t roll();
  // In [low, high).
  double between(double low, double high);
  // In [0, count). REQUIRES: count > 0.
  std::size_t below(std::size_t count);
  // A point in the ball of this radius around the origin.
  Vertex in_ball(double radius);

 private:
  std::uint64_t state_;
};

// Each facet's own copy of each of its vertices moves by up to `reach_mm`: cracks along every side.
void shake_corners(Facets& facets, double reach_mm, Dice& dice);

// Each vertex moves by up to `reach_mm`, in all facets alike: the mesh stays closed.
void shake_vertices(Facets& facets, double reach_mm, Dice& dice);

// Takes a share of the facets out, at least one, and returns them.
Facets drop_facets(Facets& facets, double share, Dice& dice);

// Swaps two corners of a share of the facets, each by chance: they face inwards.
void turn_facets(Facets& facets, double share, Dice& dice);

// Appends a share of the facets once more, as they are.
void double_facets(Facets& facets, double share, Dice& dice);

// Appends a share of the facets once more, turned round.
void double_facets_reversed(Facets& facets, double share, Dice& dice);

// Splits one side of a share of the facets, at least one, and not the neighbour's (T-junctions); the new
// vertex lies up to `reach_mm` beside the side's middle.
void split_sides(Facets& facets, double share, double reach_mm, Dice& dice);

}  // namespace contourd::models
