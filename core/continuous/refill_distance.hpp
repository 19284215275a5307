// The widest distance that fresh resin flows to reach the middle of a print's lit areas, slab by slab from
// the plate up. Not thread-safe.
//
// Resin enters from rims that are open: beside the part, or a hole that leads outside through the slabs
// beneath. A hole that is closed against the plate holds no more resin than it has, so that it counts as lit;
// as does a passage to the outside that is not in the slab itself or straight beneath it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask.hpp"
#include "core/peel/lit_cells.hpp"

namespace contourd {

// Returns the rule by which cells are lit if a single pixel is, of a size that keeps them below a quarter of
// a million: cells then have at least what the mask has, and are wider by less than a cell on each side.
[[nodiscard]] CellRule refill_cells(Pixels width, Pixels height);

class RefillDistance {
 public:
  explicit RefillDistance(Millimeters cell) : cell_(cell) {}

  // Adds a slab of cells that are lit anywhere within it. Returns the distance for refill_speed(), never less
  // than that of any section of the slab: the widest distance from an open rim, or the radius of a circle
  // around the area over sqrt(2), which is exact for a disc; the smaller of the two, for the area for which
  // it is largest. REQUIRES: as many cells as in the slabs before.
  [[nodiscard]] Millimeters add_slab(LitCells lit);
  // Adds a slab that is not known: holes of the next one are closed.
  void forget() { open_.clear(); }

 private:
  void fill_closed_holes(LitCells& lit);

  Millimeters cell_;
  std::vector<std::uint8_t> open_;  // cells of the last slab through which resin comes
};

}  // namespace contourd
