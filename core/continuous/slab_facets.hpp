// The cells above which a model's surface lies within a slab. Thread-safe (no shared state).
#pragma once

#include <cstdint>

#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/geometry/units.hpp"
#include "core/peel/lit_cells.hpp"

namespace contourd {

struct HeightSpan {
  Nanometers low, high;  // above the plate
};

// The cells of a display for which a model's copies have maps.
struct CellGrid {
  std::int32_t side = 1;  // pixels
  double outwards = 0;    // cells, by which sections are made larger than the model's
};

// Lights every cell above which a facet of a model has a point within the span, in all copies of the model.
// Where a section lies beyond a lower one, such a facet is between them. Throws ComputationStopped.
void light_facets(const PlateModel& model, HeightSpan span, const CellGrid& grid, LitCells& cells,
                  StopCheck& stop);

}  // namespace contourd
