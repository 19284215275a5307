// Renders models for viewing: parallel projection from the front, above and to the right, lit from the upper
// left. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// A place above the plate in millimetres: to the right, to the back and up.
struct PreviewPlace {
  double x, y, z;
};

// A model and its offset from its own coordinates. Holds a reference to the facets.
struct PreviewPart {
  std::span<const Facet> facets;
  PreviewPlace offset{};
  bool is_support = false;
};

// A rendered picture with its projection.
struct Preview {
  Mask picture;         // black around the parts; if there are supports, their pixels have odd values
  double scale = 1;     // pixels per millimetre
  PixelPoint origin{};  // place (0, 0, 0)

  // Returns where a place appears in the picture, visible or hidden.
  [[nodiscard]] PixelPoint at(const PreviewPlace& place) const;
};

// Draws everything below `top` (after the parts were moved) on black, at the scale at which all parts fill
// the picture: parts that were not printed are missing. Takes at most some seconds for models that take as
// long to read: facets that cover the picture thousands of times are drawn in larger pixels.
[[nodiscard]] Preview render_preview(std::span<const PreviewPart> parts, Millimeters top, Pixels width,
                                     Pixels height);
// Draws a single model that is not moved.
[[nodiscard]] Mask render_preview(std::span<const Facet> facets, Millimeters top_z, Pixels width,
                                  Pixels height);

}  // namespace contourd
