// A picture of a model for a person: parallel projection from the front, above and to the right, lit from the
// upper left. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// A model and how far it is moved from its own coordinates, in millimetres. Holds a reference to its facets.
struct PreviewPart {
  std::span<const Facet> facets;
  double x = 0, y = 0, z = 0;
};

// Draws what lies below `top` (after the parts were moved), at the scale at which all parts fill the picture,
// on black. What was not printed is missing from the picture. Takes some seconds at most for what reading
// takes as long: facets that cover the picture thousands of times are drawn in larger pixels.
[[nodiscard]] Mask render_preview(std::span<const PreviewPart> parts, Millimeters top, Pixels width,
                                  Pixels height);
// The same for one model where it is.
[[nodiscard]] Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width,
                                  Pixels height);

}  // namespace contourd
