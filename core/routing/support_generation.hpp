// Supports for what stands on a plate: what has to be held is found in one sweep of masks from the plate up,
// and led down to the plate around the models. Thread-safe (no shared state). Deterministic: the same models
// and settings give the same supports on every machine.
#pragma once

#include <optional>
#include <stop_token>

#include "core/support/support_request.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Blocks, for a second for a million facets. Nothing when `stop` was asked for meanwhile. find_overhangs()
// says how high the models may be.
[[nodiscard]] std::optional<Supports> make_supports(const SupportRequest& request,
                                                    const std::stop_token& stop = {});

}  // namespace contourd
