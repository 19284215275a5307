// Where else a place can be held that no tip reaches. Thread-safe (no shared state). Deterministic.
#pragma once

#include <vector>

#include "core/clearance/layer_stack.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// Contacts up to a millimetre beside this one, from near to far: on the model's underside, where the material
// is one with that of the contact. What an island begins with is held no more than two layers of the sweep
// higher than it begins.
[[nodiscard]] std::vector<SupportContact> neighbours_of(const SupportContact& contact,
                                                        const LayerStack& layers);

}  // namespace contourd
