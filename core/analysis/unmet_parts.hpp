// Thin parts of a model that lie between the heights of two cuts, so that no layer has them: a plate of 20 um
// between layers of 50 um. Found from facets that are nearly level, and confirmed by masks.
#pragma once

#include <chrono>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

struct UnmetPart {
  Nanometers height{};  // above the plate, in the middle of the part
  Millimeters thickness{};
  double area_mm2 = 0;  // lit there, but dark in the layers beneath and above
  Point plate_mm{};     // a place in it on the plate, from the plate's centre; mirrors undone
};

// Returns such parts of the model's first copy from the plate up: at most one between two cuts, and no
// smaller ones than `least_mm2`. Looks between at most 16 pairs of cuts, those with the largest level facets.
// A mask that overruns `mask_budget` shows no part. `cuts`: heights above the plate, ascending. Blocks for at
// most three masks a pair; without cuts, there are no parts. Memory: 12 bytes a facet. REQUIRES: the model
// has a copy.
[[nodiscard]] std::vector<UnmetPart> find_unmet_parts(const PlateModel& model, const DisplayGeometry& display,
                                                      std::span<const Nanometers> cuts, double least_mm2,
                                                      std::chrono::nanoseconds mask_budget);

}  // namespace contourd
