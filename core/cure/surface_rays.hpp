// Exact places where lines through pixels' middles cross the surface of the models on the plate. Pure
// functions, thread-safe.
//
// Facets that share a side cross a line between them once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/cure/rays.hpp"
#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/geometry/mask_budget.hpp"

namespace contourd {

// Returns the pixels of the display on which models stand, with a margin; one pixel if there are none.
[[nodiscard]] PixelWindow window_of(std::span<const PlateModel> models, const DisplayGeometry& display,
                                    std::int32_t margin);

// Returns the crossings of the facets of all models with the lines, in no order. Throws what `check` throws.
// REQUIRES: no null pointers, fewer than 2^32 lines.
[[nodiscard]] std::vector<RayCrossing> cross_surface(std::span<const PlateModel> models, const Rays& rays,
                                                     StopCheck& check);

// A range of heights above the plate on vertical lines.
struct RayRange {
  double above_mm = 0, up_to_mm = 0;  // the lower end does not belong to it
};

// Returns the crossings at which vertical lines enter models within a range of heights. Looks at facets with
// a point there only. Ends with those found so far if the budget is overrun, or after an entry for each pixel
// of the window, and at most as many again. REQUIRES: no null pointers; the lower
// end is not above the upper.
[[nodiscard]] std::vector<RayCrossing> entries_between(std::span<const PlateModel> models,
                                                       const PixelWindow& window, const RayRange& range,
                                                       MaskBudget& budget);

// Returns the stretches within the models, by ray and from low to high: where more surfaces were entered than
// left. Stretches of no length are left out. Throws what `check` throws.
[[nodiscard]] std::vector<RayStretch> stretches_within(std::vector<RayCrossing> crossings, StopCheck& check);

}  // namespace contourd
