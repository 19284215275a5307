// How much resin supports take. Thread-safe (no shared state). Deterministic.
#pragma once

#include <memory>
#include <stop_token>

#include "core/clearance/layer_stack.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {

// Of what is lit of the structure beside the models of `layers`, where pieces overlap once: from sections
// every 0.2 mm, to a few hundredths. Of no use once `stop` was asked for.
[[nodiscard]] double volume_beside_models_mm3(const std::shared_ptr<const SupportStructure>& structure,
                                              const LayerStack& layers, const std::stop_token& stop = {});

}  // namespace contourd
