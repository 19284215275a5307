// Where the models of a job and their copies stand on the plate, checked against the build area and against
// each other. Thread-safe (no shared state).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/engine/section_source.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/model/standing_model.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/print/job_refused.hpp"

namespace contourd {

// A model that is turned and scaled already.
struct ModelToPlace {
  std::string name;  // as messages have it: "the model", or its file
  std::shared_ptr<const HeightIndex> model;
  std::optional<PlateOffset> position;  // of the copies' centre; where there is room without it
  int copies = 1;
  Elevation elevation{};  // of each copy
  // Of each copy; see PlateModel. Null: none.
  std::shared_ptr<const SectionSource> holes{};

  [[nodiscard]] StandingModel standing() const { return {model, elevation}; }
};

struct BuildVolume {
  DisplayGeometry display;  // its pixels are the plate
  double height_mm = 0;

  [[nodiscard]] double width_mm() const { return display.width_mm(); }
  [[nodiscard]] double depth_mm() const { return display.height_mm(); }
  [[nodiscard]] double pitch_mm() const { return to_millimeters(display.pixel_pitch).count(); }
};

// Between models and copies that are arranged, so that cured resin does not join them.
inline constexpr Millimeters kCopyGap{2.0};

// By model, by copy: the centre of its bounds, from the plate's centre, in millimetres. Copies of a model
// with a position lie in rows and columns around it, a gap apart; everything else is put where there is room,
// a gap from all else, with its edges on the pixel grid, and in the middle of the plate if nothing has a
// position. Whether it is all on the plate: see check_arrangement(). Throws JobRefused when there is no room.
using Arrangement = std::vector<std::vector<Point>>;
[[nodiscard]] Arrangement arrange(const std::vector<ModelToPlace>& models, const BuildVolume& volume,
                                  Millimeters gap = kCopyGap);

// Throws JobRefused with a sentence when a copy reaches out of the build volume, or when two meet in a layer.
void check_arrangement(const std::vector<ModelToPlace>& models, const Arrangement& arrangement,
                       const BuildVolume& volume, Nanometers layer);

}  // namespace contourd
