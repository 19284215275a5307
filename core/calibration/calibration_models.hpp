// The models that calibration prints: bridges, a ladder of lengths, and a tower of exposures. They stand on
// the plate without supports. Pure functions; thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/calibration/dimension_fit.hpp"
#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// The layers of the memory print's bridges, from left to right.
inline constexpr std::array kBridgeLayers{1, 2, 4, 8, 16};

// Returns bridges between posts, all with the same upper side, with at least this clearance beneath the
// thickest one. In front of each bridge are as many dots as its number, from the left. REQUIRES: a layer of
// 0.001 to 1 mm; a clearance of 1 mm to 1 m.
[[nodiscard]] std::vector<Facet> bridge_model(Millimeters layer_height, Millimeters clearance);
// Returns the middle of a bridge, seen from above.
[[nodiscard]] Point bridge_middle(std::size_t bridge);

// Returns two rows of blocks, one to the right and one to the back.
[[nodiscard]] std::vector<Facet> ladder_model();
// Returns the lengths along a row of the ladder, which are measured from block to block.
struct LadderLength {
  LengthKind kind{};
  double drawn_mm = 0;
  Millimeters from{}, to{};  // from the row's end
};
[[nodiscard]] std::vector<LadderLength> ladder_lengths();

// The tower of exposures, in steps that recede at the front. Each has as many ribs there as its number, from
// 1 at the bottom.
struct ExposureTower {
  int steps = 0;
  Millimeters base{}, step{};  // heights
};

inline constexpr int kMostTowerSteps = 9;
// Returns a tower with fins and slots of 0.1, 0.2, 0.3, 0.5 and 1 mm at its back. REQUIRES: 1 to
// kMostTowerSteps steps; positive heights.
[[nodiscard]] std::vector<Facet> tower_model(const ExposureTower& tower);

}  // namespace contourd
