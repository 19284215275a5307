// Contacts that hold a part too thin to be held. Pure function, thread-safe.
#pragma once

#include <span>
#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/support/support_contact.hpp"
#include "core/support/support_settings.hpp"

namespace contourd {

// Returns the contacts whose tips reach into a part that is only one pixel of `layers` large there, as a hair
// is: it breaks off when its layers are peeled.
[[nodiscard]] std::vector<SupportContact> frail_contacts(std::span<const SupportContact> contacts,
                                                         const LitLayers& layers,
                                                         const SupportSettings& settings);

}  // namespace contourd
