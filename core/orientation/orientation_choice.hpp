// Finds which way up a model prints best. Pure function, thread-safe. Deterministic: the same choice on every
// machine.
//
// All candidate_directions() are rated by a sample of the facets. The best of them, and the model as drawn,
// are then rated by all facets. Takes half a second, and a microsecond for each facet beyond a million.
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
  // The chosen direction first, then the others, best first; (0, 0, 1), as drawn, is one of them.
  std::vector<OrientationFigures> ranked;
  std::uint32_t tried = 0;  // number of directions tried
  std::uint64_t steps = 0;  // work done: facets rated

  [[nodiscard]] const OrientationFigures& chosen() const { return ranked.front(); }
  [[nodiscard]] bool as_drawn() const { return chosen().up == Direction{0, 0, 1}; }
};

// The number of facets in the sample.
inline constexpr std::size_t kSampledFacets = 50'000;
// Returns how many directions are rated by all facets: the more facets, the fewer directions.
[[nodiscard]] std::size_t finalists_of(std::size_t facets);

// Chooses a direction in which the model fits the build volume, if there is one. The model stays as drawn
// unless another direction is clearly better. Returns nullopt if `stop` was requested meanwhile. REQUIRES: at
// least one facet, fewer than 2^30, with finite coordinates.
[[nodiscard]] std::optional<OrientationChoice> choose_orientation(std::span<const Facet> facets,
                                                                  const OrientationRequest& request,
                                                                  const std::stop_token& stop = {});

// Limits on the directions that put a face on the plate, on the evenly spread ones, and on all together.
inline constexpr std::size_t kMostFaceDirections = 16, kSpreadDirections = 200;
inline constexpr std::size_t kMostDirections = 6 + kMostFaceDirections + kSpreadDirections;
// Returns the directions to try, each of length 1 and at least 3 degrees from the earlier ones: first (0, 0,
// 1), as drawn; then the other axes both ways; then the directions that put one of the model's largest flat
// faces on the plate, largest first; then directions that are spread evenly over the sphere.
[[nodiscard]] std::vector<Direction> candidate_directions(std::span<const Facet> facets);

}  // namespace contourd
