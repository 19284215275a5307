// How a model is turned and scaled by its ticket before it stands on the plate, and what belongs to it with
// it. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"
#include "daemon/config/job_ticket.hpp"

namespace contourd {

// By the ticket and the resin's shrinkage. What is to fill the display is turned, and enlarged by what that
// takes afterwards.
void turn_and_scale(std::span<Facet> facets, const ModelTicket& ticket, const Scale& shrinkage);
void enlarge(std::span<Facet> facets, const Scale& scale);

}  // namespace contourd
