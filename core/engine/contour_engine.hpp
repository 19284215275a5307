// The contour core in one class: makes the mask of one or several models on the plate at a height.
//
// Deterministic: the same models, height and settings give the same bytes on every machine. Allocates nothing
// once it has seen its largest section. Not thread-safe; the masks and contours that it returns belong to it.
// Any number of engines, each on its own thread, may share a model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/contour_offset.hpp"
#include "core/contour/layer_cracks.hpp"
#include "core/contour/outline_stack.hpp"
#include "core/contour/slicer.hpp"
#include "core/contract/expects.hpp"
#include "core/engine/compensation.hpp"
#include "core/engine/section_source.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/mask/exposure_correction.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/picture_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/mask/rasterizer.hpp"
#include "core/model/height_index.hpp"
#include "core/model/standing_model.hpp"

namespace contourd {

// A model on the plate, which stands there once for each map in `copies`.
struct PlateModel : StandingModel {
  std::vector<PixelMap> copies;
  // Holes that are cut out of every copy: sections in the model's own millimetres at its own z. Null: none.
  std::shared_ptr<const SectionSource> holes{};
  // Pictures that are exposed instead of the model's sections; the model is the box around them, which stands
  // on the plate (see box_of()). Null: the model is exposed.
  std::shared_ptr<const PictureStack> pictures{};
  // Outlines that are exposed instead of the model's sections, as sections are; the model is the box around
  // them. Null: no such outlines.
  std::shared_ptr<const OutlineStack> outlines{};

  // True if finished layers are exposed, not sections of the model.
  [[nodiscard]] bool has_finished_layers() const { return pictures || outlines; }
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
  // Makes an engine. The sections of `beside` are exposed too, fully and by pixel centres, whatever the
  // anti-aliasing: a pixel has the greater value of the two. Compensation, threshold, contours and cracks
  // concern the models only; the uniformity mask corrects both. Throws std::invalid_argument unless the
  // display is 1 to 16384 pixels wide and high, and the uniformity mask and the pictures, if there are any,
  // have the display's size. REQUIRES: no null pointers; a model with finished layers is the only one, has
  // either pictures or outlines, stands there once and has no holes and nothing beside it.
  ContourEngine(std::vector<PlateModel> models, const EngineSettings& settings,
                std::shared_ptr<const SectionSource> beside = nullptr);
  // Makes an engine for one model that is not shared.
  ContourEngine(HeightIndex model, const EngineSettings& settings, std::vector<PixelMap> copies);

  [[nodiscard]] std::span<const PlateModel> models() const { return models_; }
  // Leaves a model's copy dark at this height and above, by their numbers from 0; models() keeps it.
  // REQUIRES: there is such a copy.
  void darken(std::size_t model, std::size_t copy, Nanometers from);
  // Exposes the sections of `beside` instead of those given before, at this height and above. Does nothing in
  // an engine that was made without any. REQUIRES: no null pointer, and a height not below those given
  // before.
  void replace_beside(std::shared_ptr<const SectionSource> beside, Nanometers from);
  // Lights all copies and all sections beside the models again, as the engine was made.
  void light_all();
  // Returns the only model. REQUIRES: one model.
  [[nodiscard]] const HeightIndex& model() const {
    expects(models_.size() == 1, "there is one model");
    return *models_.front().model;
  }

  // Returns the mask at a height above the plate: the union of the sections there, less the models' holes; or
  // the picture there, to which only threshold, uniformity mask and gamma are applied.
  // Valid until the next call. Throws std::length_error if a section crosses itself in more places than
  // MaskBudget::kMaxSidesEver.
  [[nodiscard]] const Mask& mask_at(Nanometers height);
  // Returns the mask at a height, within a budget. Null if the budget was overrun: the mask was abandoned,
  // and coverage() and cracks() are of no use until the next mask, which is not affected.
  [[nodiscard]] const Mask* mask_within(Nanometers height, MaskBudget& budget);
  // Returns the mask at a z of the model's own coordinates. REQUIRES: one model.
  [[nodiscard]] const Mask& mask_at_z(Millimeters z);

  // Returns the coverage of the last mask, including what is beside the models, before threshold, uniformity
  // mask and gamma. Valid until the next mask.
  [[nodiscard]] const Mask& coverage() const { return masks_.picture ? *masks_.picture : rasterizer_.mask(); }

  // Returns the contour loops at a height above the plate, without compensation and holes, none of pictures:
  // those of the first model, then of the second..., each in its model's own coordinates and once, however
  // many copies there are. Valid until the next call.
  [[nodiscard]] const Contours& contours_at(Nanometers height);

  // Returns the number of contour loops of the last mask or the last contours, in all models; copies count
  // once. Segments that the mask did not need linked are linked now, from the cut that made it. Meaningless
  // after an abandoned mask.
  [[nodiscard]] std::uint32_t count_loops();

  // Returns the facets crossed in the last call of any of these, in all models; copies count once.
  [[nodiscard]] std::uint32_t intersecting_facets() const { return figures_.intersecting_facets; }
  // Returns the gaps bridged in the last call of any of these, in all models; copies count once.
  [[nodiscard]] const LayerCracks& cracks() const { return figures_.cracks; }

  // Returns the coverage below which masks are left dark.
  [[nodiscard]] std::uint8_t threshold() const { return correction_.threshold(); }

  // Returns the distance up to which ends of a section's segments are joined: a pixel.
  [[nodiscard]] Millimeters join_tolerance() const { return join_tolerance_; }

 private:
  // The figures of the last call.
  struct Figures {
    std::uint32_t intersecting_facets = 0;
    std::uint32_t loops = 0;  // loops linked so far
    LayerCracks cracks;
  };
  // The cut of a model.
  struct Cut {
    Section section{};  // segments that are not linked
    Contours holes{};
    std::vector<Nanometers> dark_from{};  // heights from which on copies are dark, by copy; empty: none is
  };
  // The sections exposed beside the models.
  struct Beside {
    std::shared_ptr<const SectionSource> source;  // null: none
    PixelMap map;                                 // map of the plate
    std::vector<ConicCut> conics{};               // if the source has none, its contours are used
    Contours contours{};
    // Sources by the height from which on they replace those before, rising.
    std::vector<std::pair<Nanometers, std::shared_ptr<const SectionSource>>> later{};

    [[nodiscard]] const SectionSource& at(Nanometers height) const;
  };

  // The masks beside the rasterizer's.
  struct Masks {
    std::optional<Mask> picture{};    // the coverage; set if pictures are exposed
    std::optional<Mask> corrected{};  // set if there is something to correct
  };

  void begin_section(std::optional<Nanometers> height);
  // Calls `draw` with the map of each of a model's copies that is lit at the section's height.
  template <typename Draw>
  void for_copies(std::size_t model, const Draw& draw) {
    for (std::size_t copy = 0; copy < models_[model].copies.size(); ++copy)
      if (cuts_[model].dark_from.empty() || section_height_ < cuts_[model].dark_from[copy])
        draw(models_[model].copies[copy]);
  }
  // Cuts a model's holes, for paint(). False if the budget was overrun.
  [[nodiscard]] bool cut_holes(std::size_t model, Millimeters z, MaskBudget& budget);
  // Slice or link a model, by its number.
  void slice(std::size_t model, Millimeters z);
  void link(std::size_t model, MaskBudget& budget);
  // Cuts a model at its z, or takes its finished outlines, moves the contours outwards and adds them to the
  // mask. False if the budget was overrun.
  [[nodiscard]] bool add_to_mask(std::size_t model, Millimeters z, Millimeters offset, MaskBudget& budget);
  [[nodiscard]] bool add_moved(std::size_t model, Millimeters offset, MaskBudget& budget);
  // Cuts the sections beside the models, for paint(). False if the budget was overrun.
  [[nodiscard]] bool cut_beside(Nanometers height, MaskBudget& budget);
  // Paints the mask. Null if the budget was overrun.
  [[nodiscard]] const Mask* paint(MaskBudget& budget);
  // Draws the picture at a height.
  [[nodiscard]] const Mask& draw_picture(Nanometers height);
  // Removes everything that was added. Returns null.
  [[nodiscard]] const Mask* abandon();

  std::vector<PlateModel> models_;
  Beside beside_;
  Millimeters join_tolerance_;
  Compensation compensation_;
  ExposureCorrection correction_;
  Figures figures_;
  std::vector<Cut> cuts_;  // by model
  Nanometers section_height_{};
  ContourLinker linker_;
  Contours contours_;  // contours of one model
  ContourOffset offset_;
  Contours moved_;           // contours of one model, compensated
  Contours plate_contours_;  // contours of all models
  Rasterizer rasterizer_;
  Masks masks_;
};

}  // namespace contourd
