// The contour core behind one call: the mask of what stands on the plate, one model or several, at a height.
//
// Deterministic: the same models, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours it returns belong to it. Any
// number of engines, each on its own thread, may share a model.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/contour_offset.hpp"
#include "core/contour/layer_cracks.hpp"
#include "core/contour/slicer.hpp"
#include "core/engine/compensation.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/mask/rasterizer.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

// A model on the plate: it stands there by its own lowest point, once for each of its copies' maps.
struct PlateModel {
  std::shared_ptr<const HeightIndex> model;  // never null
  std::vector<PixelMap> copies;
};

struct EngineSettings {
  DisplayGeometry display{};
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Compensation compensation{};  // in the models' own millimetres
  ToneCurve tone{};
  std::optional<Mask> lamp{};  // see ExposureCorrection; as large as the display
};

class ContourEngine {
 public:
  // REQUIRES: no null pointers.
  // Throws std::invalid_argument unless the display is 1 to 16384 pixels wide and high, and the lamp's mask,
  // if there is one, as large as it.
  ContourEngine(std::vector<PlateModel> models, const EngineSettings& settings);
  // The same for one model that nobody shares.
  ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies);

  [[nodiscard]] std::span<const PlateModel> models() const { return models_; }
  // REQUIRES: one model.
  [[nodiscard]] const HeightIndex& model() const { return *models_.front().model; }

  // The mask at a height above the plate, which is every model's lowest point: the union of the models'
  // sections there. Valid until the next call. Throws std::length_error where a section crosses itself in
  // more places than MaskBudget::kMostSidesEver.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // The same within a budget. Null when that was overrun: the mask was abandoned, coverage() and cracks() are
  // of no use until the next one, which is computed as if nothing had happened.
  [[nodiscard]] const Mask* mask_within(Nanometers height, MaskBudget& budget);
  // The same at a z of the model's own coordinates. REQUIRES: one model.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // What the last mask covers, before threshold, lamp and gamma. Valid until the next one.
  [[nodiscard]] const Mask& coverage() const { return rasterizer_.mask(); }

  // The contour loops at a height above the plate, without compensation: those of the first model, then of
  // the second..., each in its model's own coordinates and once, however many copies there are. Valid until
  // the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // Facets crossed in the last call of any of these, in all models; copies count once.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return intersecting_facets_; }
  // What was bridged in the last call of any of these, in all models; copies count once.
  [[nodiscard]] const LayerCracks& cracks() const { return cracks_; }

  // Coverage below this is left dark in masks.
  [[nodiscard]] std::uint8_t threshold() const { return correction_.threshold(); }

  // Ends of a section's segments that miss each other by up to a pixel are joined.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  void begin_section();
  void slice(const HeightIndex& model, double z);
  void link(MaskBudget& budget);
  // False when the budget was overrun.
  [[nodiscard]] bool add_to_mask(const PlateModel& plate_model, double z, MaskBudget& budget);
  // Null when the budget was overrun.
  [[nodiscard]] const Mask* paint(MaskBudget& budget);

  std::vector<PlateModel> models_;
  Millimeters join_tolerance_;
  Compensation compensation_;
  ExposureCorrection correction_;
  std::uint32_t intersecting_facets_ = 0;
  LayerCracks cracks_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;  // of one model
  ContourOffset offset_;
  Contours moved_;           // the same, compensated
  Contours plate_contours_;  // of all
  Rasterizer rasterizer_;
  std::optional<Mask> corrected_;  // where there is something to correct
};

}  // namespace contourd
