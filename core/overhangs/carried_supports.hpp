// Recognises models that carry supports in their file. Thread-safe (no shared state). Deterministic.
#pragma once

#include <cstddef>
#include <memory>
#include <stop_token>

#include "core/model/height_index.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns the number of the model's tips; 0 if there are fewer than three. A tip is the upper end of a stem
// that rises from the plate, is pointed there, and ends at a much wider part of the model. The legs of a
// table are not pointed, and the struts of a lattice do not end at something much wider.
//
// Blocks: cuts a model with slender parts near the plate every tenth of a millimetre, and any other model
// five times. Returns early if `stop` is requested. REQUIRES: no null pointer, and a model no higher than
// kHighestSweep.
[[nodiscard]] std::size_t carried_tips(const std::shared_ptr<const HeightIndex>& model,
                                       const std::stop_token& stop = {});

// True if this number of tips holds a model for which find_overhangs() finds this number of contacts: at
// least one tip for every eight contacts, because other programs place contacts farther apart.
[[nodiscard]] bool tips_hold(std::size_t tips, double contacts);

// True if the model hangs on supports of its own: on tips that hold it. Blocks as carried_tips(), and sweeps
// a model that has tips. Returns false if `stop` is requested. The model is as carried_tips() requires it.
[[nodiscard]] bool carries_supports(const std::shared_ptr<const HeightIndex>& model,
                                    const SupportSettings& settings, const std::stop_token& stop = {});

}  // namespace contourd
