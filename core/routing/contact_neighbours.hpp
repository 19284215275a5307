// Where else a place can be held that no tip reaches. Thread-safe (no shared state). Deterministic.
#pragma once

#include <vector>

#include "core/clearance/layer_stack.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// Whether what holds an island may begin higher than it: by no more than two layers of the sweep, which hang
// free until then.
enum class IslandHold { FromItsFirstLayer, Higher };

// Contacts up to a millimetre beside this one, from near to far: on the model's underside, where the material
// is one with that of the contact. What begins an island is so in its first layer.
[[nodiscard]] std::vector<SupportContact> neighbours_of(const SupportContact& contact,
                                                        const LayerStack& layers, IslandHold hold);

}  // namespace contourd
