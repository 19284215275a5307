// Solids that stand for finished layers where a model is expected. Coordinates are millimetres: from the
// plate's centre, seen from above, and above the plate. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "core/contour/outline_stack.hpp"
#include "core/geometry/facet.hpp"
#include "core/mask/picture_stack.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// Returns the facets of the box around all pixels that the pictures light, as high as all their layers; none
// if all are dark. REQUIRES: the display has the pictures' size.
[[nodiscard]] std::vector<Facet> box_of(const PictureStack& pictures, const DisplayGeometry& display);

// Returns the facets of the box around all outlines, as high as all their layers; none if there are none.
[[nodiscard]] std::vector<Facet> box_of(const OutlineStack& outlines);

}  // namespace contourd
