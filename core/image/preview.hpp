// Renders a model for viewing: parallel projection from the front, above and to the right, lit from the upper
// left. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// A model and its offset from its own coordinates, in millimetres. Holds a reference to the facets.
struct PreviewPart {
  std::span<const Facet> facets;
  double x = 0, y = 0, z = 0;
};

// Draws everything below `top` (after the parts were moved) on black, at the scale at which all parts fill
// the picture: parts that were not printed are missing. Takes at most some seconds for models that take as
// long to read: facets that cover the picture thousands of times are drawn in larger pixels.
[[nodiscard]] Mask render_preview(std::span<const PreviewPart> parts, Millimeters top, Pixels width,
                                  Pixels height);
// Draws a single model that is not moved.
[[nodiscard]] Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width,
                                  Pixels height);

}  // namespace contourd
