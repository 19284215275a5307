// The stretches of lines through pixels' middles that a model's holes and cavities remove. Pure functions,
// thread-safe.
#pragma once

#include <vector>

#include "core/cure/rays.hpp"
#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"

namespace contourd {

// Returns the stretches that are left of a model's, by ray and from low to high. `stretches` are those within
// the model without its holes, in this order. Ends at holes have the steepness given, with its sign: they are
// right to a pixel, as masks are, along all axes. Throws what `check` throws.
[[nodiscard]] std::vector<RayStretch> without_holes(std::vector<RayStretch> stretches,
                                                    const PlateModel& model, const Rays& rays,
                                                    float steepness, StopCheck& check);

}  // namespace contourd
