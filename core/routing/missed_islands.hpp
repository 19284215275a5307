// The islands of a print's masks that its supports do not hold. A sweep's pixels are not the print's: a wall
// may be lit a layer earlier in the masks, or only there. Thread-safe (no shared state). Deterministic.
#pragma once

#include <stop_token>
#include <vector>

#include "core/support/support_contact.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// A contact for each island, from the plate up, at most kMostContacts in each list.
struct PrintedIslands {
  std::vector<SupportContact> missed;   // held by nothing; without those whose place is known as unheld
  std::vector<SupportContact> resting;  // above the plate, but no higher than the bottom exposures close
};

// Returns the islands of the masks of the request's models with these supports; none if the print's layers
// are not known, or if `stop` is requested. Blocks for one mask per layer.
[[nodiscard]] PrintedIslands missed_islands(const SupportRequest& request, const Supports& supports,
                                            const std::stop_token& stop = {});

}  // namespace contourd
