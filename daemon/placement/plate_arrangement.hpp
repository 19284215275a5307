// Arranges a job's models and their copies on the plate and checks them against the build volume and each
// other. Thread-safe (no shared state).
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/contour/outline_stack.hpp"
#include "core/engine/section_source.hpp"
#include "core/mask/picture_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/model/standing_model.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/print/job_refused.hpp"

namespace contourd {

// The supports that a model carries in its file: it gets no others if they are kept.
enum class OwnSupports { None, Kept, Overruled };

// Thrown if a model has no room on the plate beside the others.
class NoRoomOnPlate : public JobRefused {
 public:
  NoRoomOnPlate(const std::string& reason, std::size_t model) : JobRefused(reason), model_(model) {}
  // Index of the model.
  [[nodiscard]] std::size_t model() const { return model_; }

 private:
  std::size_t model_;
};

// A model that is already turned and scaled.
struct ModelToPlace {
  std::string name;  // as messages name it: "the model", or its file
  std::shared_ptr<const HeightIndex> model;
  std::optional<PlateOffset> position;  // centre of all copies; nullopt: wherever there is room
  int copies = 1;
  Elevation elevation{};  // height of each copy above the plate
  OwnSupports own_supports = OwnSupports::None;
  // Drain holes in each copy (see PlateModel); null if there are none.
  std::shared_ptr<const SectionSource> holes{};
  // Finished layers that are exposed instead (see PlateModel); null for a model.
  std::shared_ptr<const PictureStack> pictures{};
  std::shared_ptr<const OutlineStack> outlines{};

  [[nodiscard]] StandingModel standing() const { return {model, elevation}; }
};

// The space in which the machine can print.
struct BuildVolume {
  DisplayGeometry display;  // the plate is as large as the display's picture
  double height_mm = 0;

  [[nodiscard]] double width_mm() const { return display.width_mm(); }
  [[nodiscard]] double depth_mm() const { return display.height_mm(); }
  [[nodiscard]] std::array<double, 3> size_mm() const { return {width_mm(), depth_mm(), height_mm}; }
  [[nodiscard]] double pitch_mm() const { return to_millimeters(display.pixel_pitch).count(); }
};

// The gap between arranged models and copies, so that cured resin does not join them.
inline constexpr Millimeters kCopyGap{2.0};

// For each model and each of its copies, the centre of the bounds, from the plate's centre, in millimetres.
using Arrangement = std::vector<std::vector<Point>>;
// Arranges the models. Copies of a model with a position stand in rows and columns around it, `gap` apart.
// Every other copy is put where there is room, at least `gap` from all others, with its edges on the pixel
// grid; if no model has a position, all of them together are centred on the plate. Throws JobRefused if there
// is not enough room, NoRoomOnPlate for a model without a position. Positions that reach over the plate's
// edge are found by check_arrangement().
[[nodiscard]] Arrangement arrange(const std::vector<ModelToPlace>& models, const BuildVolume& volume,
                                  Millimeters gap = kCopyGap);

// Throws JobRefused if a copy reaches over the edge of the build area or if two copies collide in a layer.
// `layer` is the step in height of the search for collisions.
void check_arrangement(const std::vector<ModelToPlace>& models, const Arrangement& arrangement,
                       const BuildVolume& volume, Nanometers layer);

// Returns a warning if contours that are moved outwards by `growth` reach over the edge of the display; else
// an empty text. A part that fills the display is not refused for some micrometres.
[[nodiscard]] std::string growth_warning(const std::vector<ModelToPlace>& models,
                                         const Arrangement& arrangement, const BuildVolume& volume,
                                         Micrometers growth);

}  // namespace contourd
