// How high a model is to stand above the plate. Thread-safe (no shared state). Deterministic.
#pragma once

#include "core/geometry/units.hpp"
#include "core/model/height_index.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// On the plate where it has a flat face there that holds it, else `settings.lift`, made a whole number of
// layers, rounded up.
//
// It stands by itself where three things are so. Its face is flat: the first layer covers at least half of
// what the second does; a ball's covers a third, a point's a ninth. It is large enough: a tenth of the widest
// layer; peel pulls with all of that at what sticks to the plate, and resin that is exposed for long sticks
// some ten times as well to it as to the film. And it does not tip: the centre of mass is over the convex
// hull of the face.
//
// Blocks: cuts it 34 times. REQUIRES: layer > 0.
[[nodiscard]] Nanometers support_lift(const HeightIndex& model, const SupportSettings& settings,
                                      Nanometers layer);

}  // namespace contourd
