// The contour core behind one call: the mask of a model at a height.
//
// Deterministic: the same model, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours it returns belong to it.
#pragma once

#include <vector>

#include "core/contour_loops.hpp"
#include "core/height_index.hpp"
#include "core/mask.hpp"
#include "core/pixel_map.hpp"
#include "core/rasterizer.hpp"
#include "core/slicer.hpp"

namespace contourd {

class ContourEngine {
 public:
  // `copies`: one map for each copy of the model on the display.
  // Throws std::invalid_argument unless the display is 1 to 16384 pixels wide and high.
  ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                std::vector<PixelMap> copies);

  [[nodiscard]] const HeightIndex& model() const { return model_; }

  // The mask at a height above the model's lowest point. Valid until the next call.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // The same at a z of the model's own coordinates.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // The contour loops at a height above the model's lowest point, in the model's own coordinates (one copy).
  // Valid until the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // Facets crossed in the last call of either.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return section_.intersecting_facets; }

  // Ends of a section's segments that miss each other by up to a pixel are joined.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  [[nodiscard]] double z_of(Nanometers height) const;

  HeightIndex model_;
  std::vector<PixelMap> copies_;
  Millimeters join_tolerance_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;
  Rasterizer rasterizer_;
};

}  // namespace contourd
