// Turns and scales a model, or facets that move with it, as its ticket says, before it is placed on the
// plate. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/placement/plate_arrangement.hpp"

namespace contourd {

// Turns the facets by the ticket's rotation and scales them by its scale and the resin's shrinkage. If the
// ticket asks for `fit`, its scale is ignored: enlarge() follows, once the size of the turned model is known.
void turn_and_scale(std::span<Facet> facets, const ModelTicket& ticket, const Scale& shrinkage);
// Scales the facets.
void enlarge(std::span<Facet> facets, const Scale& scale);
// Turns and scales the facets of a model; with `fit`, to the size at which it fills the volume. Returns the
// scale without the resin's shrinkage.
Scale turn_to_size(std::span<Facet> facets, const ModelTicket& ticket, const BuildVolume& volume,
                   const JobSettings& settings);

}  // namespace contourd
