// Feet on the plate: as wide as the settings have them where there is room, else narrower. Thread-safe (no
// shared state). Deterministic.
#pragma once

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_primitive.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// The foot of a branch that arrives there with this radius. REQUIRES: a place on the plate.
[[nodiscard]] Frustum foot_at(const PlatePoint& place, double radius_mm, const ClearanceField& field,
                              const SupportSettings& settings);

}  // namespace contourd
