// Supports of a job: lifts models that do not stand by themselves, arranges all models with room for supports
// and generates the supports. Thread-safe (no shared state).
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/routing/support_layout.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/prepare/job_content.hpp"
#include "daemon/prepare/plate_arrangement.hpp"

namespace contourd {

// Finds out which models carry supports in their files, and sets the elevations of the others to multiples of
// `layer`. Throws JobRefused if a lifted model is too high. If `stop` is requested, the elevations mean
// nothing.
void lift_models(std::vector<ModelToPlace>& models, const SupportSettings& settings, Nanometers layer,
                 const BuildVolume& volume, const std::stop_token& stop = {});

// An arrangement of models and their supports.
struct HeldPlate {
  Arrangement arrangement;
  Supports supports;
};

// Models to arrange and support on a plate.
struct PlateToHold {
  const std::vector<ModelToPlace>& models;
  const BuildVolume& volume;
  const SupportSettings& settings;
  const JobContent& content;
  const PrintedLayers& printed;
  Nanometers layer;  // the thinnest; the step in height of the search for collisions
};
// Arranges the models and generates their supports; nullopt if `stop` was requested. If no model needs
// supports, the arrangement is the same as without; otherwise there is room for feet between all models.
// Throws JobRefused as arrange() and check_arrangement() do, and JobTooLarge. Blocks as make_supports() does.
[[nodiscard]] std::optional<HeldPlate> hold_plate(const PlateToHold& plate, const std::stop_token& stop);

// Returns the models and their copies in the form that the engine takes.
[[nodiscard]] std::vector<PlateModel> stand_on_plate(const std::vector<ModelToPlace>& models,
                                                     const Arrangement& arrangement,
                                                     const DisplayGeometry& display);

}  // namespace contourd
