// The amount of resin that supports take. Thread-safe (no shared state). Deterministic.
#pragma once

#include <memory>
#include <stop_token>

#include "core/clearance/lit_layers.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {

// Returns the volume of the structure outside the models of `layers`, with overlapping primitives counted
// once, from sections every 0.2 mm: exact to a few hundredths. Unusable if `stop` was requested.
[[nodiscard]] double volume_beside_models_mm3(const std::shared_ptr<const SupportStructure>& structure,
                                              const LitLayers& layers, const std::stop_token& stop = {});

}  // namespace contourd
