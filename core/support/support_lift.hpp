// The height at which a model is to stand above the plate. Thread-safe (no shared state). Deterministic.
#pragma once

#include "core/geometry/units.hpp"
#include "core/model/height_index.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns 0 if the model stands on the plate by itself, else `settings.lift` rounded up to a whole number of
// layers.
//
// A model stands by itself if three things hold. Its lowest face is flat: the first layer covers at least
// half of what the second does (a ball's covers a third, a cone's tip a ninth). A face that is tilted or
// uneven by no more than `settings.closed_gap` is as good: at that height, the section covers at least 80 %
// of what it does three times as high (a ball's covers a third, a cylinder's on its side 58 %). The face is
// large enough: a tenth of the widest layer, because peel pulls with the whole of that layer, and resin that
// is exposed for long sticks about ten times better to the plate than to the film. A face of three or more
// separate feet may be smaller: a file with such feet was made to stand on them. And the model does not tip:
// its centre of mass is over the convex hull of the face.
//
// Blocks: cuts the model 36 times. REQUIRES: layer > 0.
[[nodiscard]] Nanometers support_lift(const HeightIndex& model, const SupportSettings& settings,
                                      Nanometers layer);

}  // namespace contourd
