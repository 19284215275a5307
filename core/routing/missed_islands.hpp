// The islands of a print's masks that its supports do not hold. A sweep's pixels are not the print's: a wall
// may be lit a layer earlier in the masks, or only there. Thread-safe (no shared state). Deterministic.
#pragma once

#include <stop_token>
#include <vector>

#include "core/support/support_contact.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Returns a contact for each island of the masks of the request's models with these supports, from the plate
// up: none for those that rest on the plate or whose place is known as unheld, at most kMostContacts. Returns
// nothing if the print's layers are not known, or if `stop` is requested. Blocks for one mask per layer.
[[nodiscard]] std::vector<SupportContact> missed_islands(const SupportRequest& request,
                                                         const Supports& supports,
                                                         const std::stop_token& stop = {});

}  // namespace contourd
