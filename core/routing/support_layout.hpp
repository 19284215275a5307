// Generates supports: tips, branches, feet, and the places that cannot be held. Thread-safe (no shared
// state). Deterministic.
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

// Lays out the supports; nullopt if `stop` is requested. `layers` holds all layers of everything that stands
// on the plate.
[[nodiscard]] std::optional<Supports> lay_out_supports(std::vector<SupportContact> contacts,
                                                       const LitLayers& layers,
                                                       const DisplayGeometry& build_area,
                                                       const SupportSettings& settings,
                                                       const std::stop_token& stop = {});

// Generates supports for the models on a plate: finds the places that have to be held in one sweep of masks
// from the plate up, and leads supports from them around the models down to the plate. The same models and
// settings give the same supports on every machine. Returns nullopt if `stop` is requested. Blocks: about a
// second per million facets. find_overhangs() limits the height of the models.
[[nodiscard]] std::optional<Supports> make_supports(const SupportRequest& request,
                                                    const std::stop_token& stop = {});

}  // namespace contourd
