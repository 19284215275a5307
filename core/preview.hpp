// A picture of a model for a person: parallel projection from the front, above and to the right, lit from the
// upper left. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/facet.hpp"
#include "core/mask.hpp"

namespace contourd {

// Draws what lies below `top_z` (model coordinates), at the scale at which the whole model fills the picture,
// on black. What was not printed is missing from the picture.
[[nodiscard]] Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width,
                                  Pixels height);

}  // namespace contourd
