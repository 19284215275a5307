// Tries a direction: cuts the turned model into layers and finds the contacts that hold it, as the generation
// of supports does. Thread-safe (no shared state). Deterministic.
#pragma once

#include <span>
#include <stop_token>

#include "core/geometry/facet.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd {

// A trial has at most this many layers: a higher model is tried on a smaller scale, with coarser layers.
inline constexpr int kMostTrialLayers = 500;

// Replaces the estimates of contacts, supports and the largest layer, and whether the model stands, by what
// the layers show. The figures are those of the rating, with the same request; they stay estimates if the
// model is too large, or its sections are too costly to cut that many. The facets have been repaired, and
// face outwards. Stops soon when a stop is requested; the result is then of no use.
[[nodiscard]] OrientationFigures try_orientation(std::span<const Facet> facets,
                                                 const OrientationFigures& figures,
                                                 const OrientationRequest& request,
                                                 const std::stop_token& stop = {});

}  // namespace contourd
