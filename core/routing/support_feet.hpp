// Feet on the plate, as wide as the settings ask if there is room, else narrower. Thread-safe (no shared
// state). Deterministic.
#pragma once

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_primitive.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns the foot of a branch with this radius that reaches the plate at `place`. REQUIRES: place.z == 0.
[[nodiscard]] Frustum foot_at(const PlatePoint& place, double radius_mm, const ClearanceField& field,
                              const SupportSettings& settings);

}  // namespace contourd
