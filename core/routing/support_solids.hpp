// Converts a support tree to primitives. Thread-safe (no shared state). Deterministic.
#pragma once

#include <vector>

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_primitive.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns cones for the tips, branches with a ball at every junction and bend, and feet.
[[nodiscard]] std::vector<SupportPrimitive> solids_of(const SupportTree& tree, const ClearanceField& field,
                                                      const SupportSettings& settings);

// Returns the foot of a branch with this radius that reaches the plate at `place`. REQUIRES: place.z == 0.
[[nodiscard]] Frustum foot_at(const PlatePoint& place, double radius_mm, const ClearanceField& field,
                              const SupportSettings& settings);

}  // namespace contourd
