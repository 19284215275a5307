// Lays out the supports for the places that a sweep has found: tips, branches, feet, and the places that
// cannot be held. Thread-safe (no shared state). Deterministic.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Returns the supports; nullopt if `stop` is requested. `layers` holds all layers of everything that stands
// on the plate.
[[nodiscard]] std::optional<Supports> lay_out_supports(std::vector<SupportContact> contacts,
                                                       const LitLayers& layers,
                                                       const DisplayGeometry& build_area,
                                                       const SupportSettings& settings,
                                                       const std::stop_token& stop = {});

}  // namespace contourd
