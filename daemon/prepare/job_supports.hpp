// Supports of a job: lifts models that do not stand by themselves, arranges all models with room for supports
// and generates the supports. Thread-safe (no shared state).
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/routing/support_layout.hpp"
#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/job_content.hpp"

namespace contourd {

// Finds the supports that a model carries in its file. The policy On overrules them; InFile presupposes them.
// Blocks as carries_supports() does.
[[nodiscard]] OwnSupports find_own_supports(const std::shared_ptr<const HeightIndex>& model,
                                            const SupportSettings& settings, SupportPolicy policy,
                                            const std::stop_token& stop = {});
// Returns a warning about a model's own supports, in which `program` adds supports; empty if it has none.
[[nodiscard]] std::string own_supports_sentence(std::string_view model, OwnSupports own,
                                                std::string_view program);

// Returns a warning if a model that does not stand by itself would do so if it were turned by at most five
// degrees, with `advice` on how to turn it; empty if not. Blocks as nearly_level_base() does.
[[nodiscard]] std::string tilted_base_sentence(std::string_view name, const HeightIndex& model,
                                               const SupportSettings& settings, Nanometers layer,
                                               std::string_view advice);

// Sets the elevations of models that do not keep supports of their own to multiples of `layer`. Throws
// JobRefused if a lifted model is too high.
void lift_models(std::vector<ModelToPlace>& models, const SupportSettings& settings, Nanometers layer,
                 const BuildVolume& volume);

// Returns the gap between models that stand on supports: room for one foot, and its clearance on both sides.
[[nodiscard]] Millimeters gap_for_supports(const SupportSettings& settings);

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
