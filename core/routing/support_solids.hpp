// A support tree as primitives. Thread-safe (no shared state). Deterministic.
#pragma once

#include <vector>

#include "core/clearance/clearance_field.hpp"
#include "core/routing/support_tree.hpp"
#include "core/support/support_primitive.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Cones for the tips, branches with a ball wherever they meet or bend, feet.
[[nodiscard]] std::vector<SupportPrimitive> solids_of(const SupportTree& tree, const ClearanceField& field,
                                                      const SupportSettings& settings);

}  // namespace contourd
