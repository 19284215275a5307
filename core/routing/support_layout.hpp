// Holds the places that a sweep has found: tips, branches, feet, and what cannot be held. Thread-safe (no
// shared state). Deterministic.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/clearance/layer_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// `layers`: of all that stands on the plate, whole. Nothing when `stop` was asked for meanwhile.
[[nodiscard]] std::optional<Supports> lay_out_supports(std::vector<SupportContact> contacts,
                                                       const LayerStack& layers,
                                                       const DisplayGeometry& build_area,
                                                       const SupportSettings& settings,
                                                       const std::stop_token& stop = {});

}  // namespace contourd
