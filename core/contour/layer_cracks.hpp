// The gaps that were bridged to close a layer's contours where the model has cracks. A value; thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/geometry/units.hpp"

namespace contourd {

struct LayerCracks {
  // Ends that missed each other by more than kNoGap and less than the tolerance, and were joined.
  std::uint32_t gaps_closed = 0;
  // The widest distance bridged, a closed open chain's included.
  Millimeters widest_gap{};
  // Chains that no join within the tolerance could close. Each was closed all the same, so that nothing can
  // spill, and the area that it encloses is a guess; a chain that is an internal wall with only one side was
  // left out instead.
  std::uint32_t open_chains = 0;

  // Chains that were walked against their facets' winding, because nothing else closes them (turned facets).
  std::uint32_t turned_chains = 0;

  // True if the contours go beyond what the file says.
  [[nodiscard]] bool has_guesses() const { return open_chains > 0 || turned_chains > 0; }

  // The widest gap that is ignored. A vertex in the middle of another facet's side misses the side by a
  // float's rounding, some nanometres, which a flat slope makes wider. No one would see 0.1 um.
  static constexpr Millimeters kNoGap{1e-4};

  bool operator==(const LayerCracks&) const = default;

  LayerCracks& operator+=(const LayerCracks& other) {
    gaps_closed += other.gaps_closed;
    widest_gap = std::max(widest_gap, other.widest_gap);
    open_chains += other.open_chains;
    turned_chains += other.turned_chains;
    return *this;
  }
};

}  // namespace contourd
