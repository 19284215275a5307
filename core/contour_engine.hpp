// The contour core behind one call: the mask of a model at a height.
//
// Deterministic: the same model, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours it returns belong to it. Any
// number of engines, each on its own thread, may share a model.
#pragma once

#include <memory>
#include <vector>

#include "core/contour_loops.hpp"
#include "core/height_index.hpp"
#include "core/layer_cracks.hpp"
#include "core/mask.hpp"
#include "core/pixel_map.hpp"
#include "core/rasterizer.hpp"
#include "core/slicer.hpp"

namespace contourd {

// A model that stands on the plate, with one map for each of its copies on the display.
struct PlateModel {
  std::shared_ptr<const HeightIndex> model;  // never null
  std::vector<PixelMap> copies;
};

class ContourEngine {
 public:
  // REQUIRES: at least one model.
  // Throws std::invalid_argument unless the display is 1 to 16384 pixels wide and high.
  ContourEngine(std::vector<PlateModel> models, const DisplayGeometry& display, AntiAliasing anti_aliasing);
  // The same for one model that is nobody else's.
  ContourEngine(HeightIndex model, const DisplayGeometry& display, AntiAliasing anti_aliasing,
                std::vector<PixelMap> copies);

  [[nodiscard]] const std::vector<PlateModel>& models() const { return models_; }
  // The first of them.
  [[nodiscard]] const HeightIndex& model() const { return *models_.front().model; }

  // The mask at a height above each model's lowest point. Valid until the next call.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // The same at a z of the models' own coordinates.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // The contour loops of the first model at a height above its lowest point, in its own coordinates (one
  // copy). Valid until the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // Facets crossed in the last call of either.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return intersecting_facets_; }
  // What was bridged in the last call of either, each model counted once, however many copies it has.
  [[nodiscard]] const LayerCracks& cracks() const { return cracks_; }

  // Ends of a section's segments that miss each other by up to a pixel are joined.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  void begin_section();
  void cut(const HeightIndex& model, double z);
  void link();
  void add_sides(const PlateModel& plate_model, double z);

  std::vector<PlateModel> models_;
  Millimeters join_tolerance_;
  std::uint32_t intersecting_facets_ = 0;
  LayerCracks cracks_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;
  Rasterizer rasterizer_;
};

}  // namespace contourd
