// Finds which way up a model prints best. Pure function, thread-safe. Deterministic: the same choice on every
// machine.
//
// All candidate_directions() are rated by a sample of the facets. The best of them, and the model as drawn,
// are then rated by all facets; and the best of those are tried. Takes one to three seconds, and some
// microseconds for each facet beyond a million.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd {

struct OrientationChoice {
  // The directions that were tried: the chosen one first, then the others, best first; (0, 0, 1), as drawn,
  // is one of them.
  std::vector<OrientationFigures> ranked;
  std::uint32_t tried = 0;    // number of directions tried
  std::uint64_t steps = 0;    // work done: facets rated
  bool own_supports = false;  // the model carries supports in its file, so it stays as drawn

  [[nodiscard]] const OrientationFigures& chosen() const { return ranked.front(); }
  [[nodiscard]] bool as_drawn() const { return chosen().up == Direction{0, 0, 1}; }
};

// The number of facets in the sample.
inline constexpr std::size_t kSampledFacets = 50'000;
// Returns how many directions are rated by all facets: the more facets, the fewer directions.
[[nodiscard]] std::size_t finalists_of(std::size_t facets);
// Returns how many directions are tried at most.
[[nodiscard]] std::size_t trials_of(std::size_t facets);

// Chooses a direction in which the model fits the build volume, if there is one. The model stays as drawn
// unless another direction is clearly better, and always if it carries supports in its file and is
// to keep them; but a base that
// is drawn nearly level is put flat on the plate. Returns nullopt if `stop` was requested meanwhile.
// REQUIRES: at least one facet, fewer than 2^30, with finite coordinates.
[[nodiscard]] std::optional<OrientationChoice> choose_orientation(std::span<const Facet> facets,
                                                                  const OrientationRequest& request,
                                                                  const std::stop_token& stop = {});

}  // namespace contourd
