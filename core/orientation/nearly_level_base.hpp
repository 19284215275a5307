// Finds the flat face on which a model would rest that is drawn a few degrees off the level. Pure function,
// thread-safe.
#pragma once

#include <optional>
#include <span>

#include "core/geometry/facet.hpp"
#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// The cosine of 5 degrees, by which a base may be off the level that is meant to be flat on the plate.
inline constexpr double kCosNearlyLevel = 0.9961;

struct LevelBase {
  Direction up;         // of length 1: the direction that points up if the base is level
  double tilt_deg = 0;  // by which the model has to be turned
};

// Returns the largest flat face, at most 5 degrees off the level, on which the model would stand by itself as
// support_lift() judges; nullopt if there is none. Blocks: turns a copy of the model for each flat face that
// is nearly level. REQUIRES: layer > 0, finite coordinates.
[[nodiscard]] std::optional<LevelBase> nearly_level_base(std::span<const Facet> facets,
                                                         const SupportSettings& settings, Nanometers layer);

}  // namespace contourd
