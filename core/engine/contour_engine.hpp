// The contour core behind one call: the mask of what stands on the plate, one model or several, at a height.
//
// Deterministic: the same models, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours it returns belong to it. Any
// number of engines, each on its own thread, may share a model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/contour_offset.hpp"
#include "core/contour/layer_cracks.hpp"
#include "core/contour/slicer.hpp"
#include "core/contract/expects.hpp"
#include "core/engine/compensation.hpp"
#include "core/engine/section_source.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/mask/rasterizer.hpp"
#include "core/model/height_index.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

// A model on the plate: it stands there once for each of its copies' maps.
struct PlateModel : StandingModel {
  std::vector<PixelMap> copies;
  // What is taken out of it, in every copy: sections in its own millimetres at its own z. Null: nothing.
  std::shared_ptr<const SectionSource> holes{};
};

struct EngineSettings {
  DisplayGeometry display{};
  AntiAliasing anti_aliasing = AntiAliasing::On;
  Compensation compensation{};  // in the models' own millimetres
  ToneCurve tone{};
  std::optional<Mask> uniformity{};  // see ExposureCorrection; as large as the display
};

class ContourEngine {
 public:
  // REQUIRES: no null pointers.
  // `beside` is exposed too, by pixel centres and fully, whatever the anti-aliasing: a pixel has the greater
  // value of the two. Compensation and threshold are the models' alone, as all that contours and cracks tell;
  // the lamp's mask makes its white what it makes of theirs. Throws std::invalid_argument unless the display
  // is 1 to 16384 pixels wide and high, and the lamp's mask, if there is one, as large as it.
  ContourEngine(std::vector<PlateModel> models, const EngineSettings& settings,
                std::shared_ptr<const SectionSource> beside = nullptr);
  // The same for one model that nobody shares.
  ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies);

  [[nodiscard]] std::span<const PlateModel> models() const { return models_; }
  // REQUIRES: one model.
  [[nodiscard]] const HeightIndex& model() const {
    expects(models_.size() == 1, "there is one model");
    return *models_.front().model;
  }

  // The mask at a height above the plate: the union of the sections there, less the models' holes. Valid
  // until the next call. Throws std::length_error where a section crosses itself in more places than
  // MaskBudget::kMaxSidesEver.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // The same within a budget. Null when that was overrun: the mask was abandoned, coverage() and cracks() are
  // of no use until the next one, which is computed as if nothing had happened.
  [[nodiscard]] const Mask* mask_within(Nanometers height, MaskBudget& budget);
  // The same at a z of the model's own coordinates. REQUIRES: one model.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // What the last mask covers, what is beside the models included, before threshold, uniformity mask and
  // gamma. Valid until the next one.
  [[nodiscard]] const Mask& coverage() const { return rasterizer_.mask(); }

  // The contour loops at a height above the plate, without compensation and holes: those of the first model,
  // then of the second..., each in its model's own coordinates and once, however many copies there are. Valid
  // until the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // How many contour loops the last mask or the last contours have, in all models; copies count once. What a
  // mask did not need linked is linked now, from the cut that made it. Of an abandoned mask it says nothing.
  [[nodiscard]] std::uint32_t count_loops();

  // Facets crossed in the last call of any of these, in all models; copies count once.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return figures_.intersecting_facets; }
  // What was bridged in the last call of any of these, in all models; copies count once.
  [[nodiscard]] const LayerCracks& cracks() const { return figures_.cracks; }

  // Coverage below this is left dark in masks.
  [[nodiscard]] std::uint8_t threshold() const { return correction_.threshold(); }

  // Ends of a section's segments that miss each other by up to a pixel are joined.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  // Of the last call.
  struct Figures {
    std::uint32_t intersecting_facets = 0;
    std::uint32_t loops = 0;  // that are linked
    LayerCracks cracks;
  };
  // What is exposed beside the models.
  struct Beside {
    std::shared_ptr<const SectionSource> source;  // null: nothing
    PixelMap map;                                 // of the plate
    std::vector<ConicCut> conics{};               // or contours, of a source that has none
    Contours contours{};
  };

  void begin_section();
  // Of a model, for paint().
  [[nodiscard]] bool cut_holes(std::size_t model, Millimeters z, MaskBudget& budget);
  // These for a model, by its number.
  void slice(std::size_t model, Millimeters z);
  void link(std::size_t model, MaskBudget& budget);
  // Cuts it at its z and moves the contours outwards. False when the budget was overrun.
  [[nodiscard]] bool add_to_mask(std::size_t model, Millimeters z, Millimeters offset, MaskBudget& budget);
  [[nodiscard]] bool add_moved(const PlateModel& model, Millimeters offset, MaskBudget& budget);
  // What is beside the models, for paint(). False when the budget was overrun.
  [[nodiscard]] bool cut_beside(Nanometers height, MaskBudget& budget);
  // Null when the budget was overrun.
  [[nodiscard]] const Mask* paint(MaskBudget& budget);
  // Forgets what was added. Null.
  [[nodiscard]] const Mask* abandon();

  std::vector<PlateModel> models_;
  Beside beside_;
  Millimeters join_tolerance_;
  Compensation compensation_;
  ExposureCorrection correction_;
  Figures figures_;
  std::vector<Section> sections_;  // by model: what of its cut is not linked
  std::vector<Contours> holes_;    // by model
  ContourLinker linker_;
  Contours contours_;  // of one model
  ContourOffset offset_;
  Contours moved_;           // the same, compensated
  Contours plate_contours_;  // of all
  Rasterizer rasterizer_;
  std::optional<Mask> corrected_;  // where there is something to correct
};

}  // namespace contourd
