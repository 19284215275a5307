// Finds places near a contact that can be held instead if no tip reaches the contact itself. Thread-safe (no
// shared state). Deterministic.
#pragma once

#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// How high an island may be held: in its first layer only, or up to two layers of the sweep higher, which
// then hang free until the support reaches them.
enum class IslandHold { FromItsFirstLayer, Higher };

// Returns copies of the contact up to a millimetre beside it, from near to far: on the model's underside,
// where the material is connected to the contact's. An island's neighbours are connected to it in its first
// layer with IslandHold::FromItsFirstLayer.
[[nodiscard]] std::vector<SupportContact> neighbours_of(const SupportContact& contact,
                                                        const LitLayers& layers, IslandHold hold);

}  // namespace contourd
