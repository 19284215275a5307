// Recognises models that carry supports in their file. Thread-safe (no shared state). Deterministic.
#pragma once

#include <memory>
#include <stop_token>

#include "core/model/height_index.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// True if the model hangs on supports of its own: it has at least three tips, and one for every eight
// contacts that find_overhangs() finds; each contact is within 10 mm of a tip, and none holds an island. A
// tip is the upper end of a stem that rises from the plate, gets thin in its last three millimetres, or ends
// in a ball above a neck, and holds a much wider part of the model together with other tips. The legs of a
// table and the columns of a carport do not get thin at their upper end, whatever their feet; a parasol and a
// chessman have one stem; and the struts of a lattice do not end at something much wider.
//
// Blocks: cuts a model with slender parts near the plate every tenth of a millimetre, and sweeps it if it has
// tips; cuts any other model five times. Returns false if `stop` is requested. REQUIRES: no null pointer,
// and a model no higher than kHighestSweep.
[[nodiscard]] bool carries_supports(const std::shared_ptr<const HeightIndex>& model,
                                    const SupportSettings& settings, const std::stop_token& stop = {});

}  // namespace contourd
