// Finds which way up a model prints best. Pure function, thread-safe. Deterministic: the same choice on every
// machine.
//
// All candidate_directions() are rated by a sample of the facets, then the best of them, and the model as it
// is drawn, by all: half a second, and a microsecond for each facet beyond a million.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/orientation/orientation_figures.hpp"

namespace contourd {

struct OrientationChoice {
  // The chosen one first, then the others, the best first; as drawn, (0, 0, 1), is one of them.
  std::vector<OrientationFigures> ranked;
  std::uint32_t tried = 0;  // directions
  std::uint64_t steps = 0;  // of work: facets rated

  [[nodiscard]] const OrientationFigures& chosen() const { return ranked.front(); }
  [[nodiscard]] bool as_drawn() const { return chosen().up == Direction{0, 0, 1}; }
};

// Facets in the sample.
inline constexpr std::size_t kSampledFacets = 50'000;
// How many directions are rated by all facets: the more facets, the fewer.
[[nodiscard]] std::size_t finalists_of(std::size_t facets);

// A direction is chosen whose model fits the build, if there is one. What stands as it is drawn and is to be
// held nowhere stays so unless another is clearly better, and so does everything else. Nothing when `stop`
// was asked for meanwhile. REQUIRES: at least one facet, fewer than 2^30, with finite coordinates.
[[nodiscard]] std::optional<OrientationChoice> choose_orientation(std::span<const Facet> facets,
                                                                  const OrientationRequest& request,
                                                                  const std::stop_token& stop = {});

}  // namespace contourd
