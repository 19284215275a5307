// The contour core behind one call: the mask of a model at a height.
//
// Deterministic: the same model, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours it returns belong to it.
#pragma once

#include <optional>
#include <vector>

#include "core/compensation.hpp"
#include "core/contour_loops.hpp"
#include "core/contour_offset.hpp"
#include "core/exposure_correction.hpp"
#include "core/height_index.hpp"
#include "core/mask.hpp"
#include "core/pixel_map.hpp"
#include "core/rasterizer.hpp"
#include "core/slicer.hpp"

namespace contourd {

struct EngineSettings {
  DisplayGeometry display{};
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Compensation compensation{};  // in the model's own millimetres
  ToneCurve tone{};
  std::optional<Mask> lamp{};  // see ExposureCorrection; as large as the display
};

class ContourEngine {
 public:
  // `copies`: one map for each copy of the model on the display.
  // Throws std::invalid_argument unless the display is 1 to 16384 pixels wide and high, and the lamp's mask,
  // if there is one, as large as it.
  ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies);

  [[nodiscard]] const HeightIndex& model() const { return model_; }

  // The mask at a height above the model's lowest point. Valid until the next call.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // The same at a z of the model's own coordinates.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // What the last mask covers, before threshold, lamp and gamma. Valid until the next one.
  [[nodiscard]] const Mask& coverage() const { return mask_; }

  // The contour loops at a height above the model's lowest point, in the model's own coordinates (one copy),
  // as the model has them: without compensation. Valid until the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // Facets crossed in the last call of either.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return section_.intersecting_facets; }

  // Ends of a section's segments that miss each other by up to a pixel are joined.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  [[nodiscard]] double z_of(Nanometers height) const;
  [[nodiscard]] Millimeters offset_at_z(double z) const;
  // What is to be filled: the contours, or nothing when the section's own segments close.
  [[nodiscard]] const Contours* contours_to_fill(double z);
  void add_sides(const Contours* contours, const PixelMap& copy);

  HeightIndex model_;
  std::vector<PixelMap> copies_;
  Millimeters join_tolerance_;
  Compensation compensation_;
  ExposureCorrection correction_;
  Section section_;
  ContourLinker linker_;
  Contours contours_;
  ContourOffset offset_;
  Contours moved_;
  Rasterizer rasterizer_;
  Mask mask_;
  std::optional<Mask> corrected_;  // where there is something to correct
};

}  // namespace contourd
