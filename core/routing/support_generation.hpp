// Generates supports for the models on a plate: finds the places that have to be held in one sweep of masks
// from the plate up, and leads supports from them around the models down to the plate. Thread-safe (no shared
// state). Deterministic: the same models and settings give the same supports on every machine.
#pragma once

#include <optional>
#include <stop_token>

#include "core/support/support_request.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Returns the supports; nullopt if `stop` is requested. Blocks: about a second per million facets.
// find_overhangs() limits the height of the models.
[[nodiscard]] std::optional<Supports> make_supports(const SupportRequest& request,
                                                    const std::stop_token& stop = {});

}  // namespace contourd
