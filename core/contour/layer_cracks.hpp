// What a cracked model cost a layer: the gaps that were bridged to close its contours. A value; thread-safe.
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
  // Chains that no join within the tolerance could close. They were closed all the same (each is part of a
  // loop) or, an internal wall of one side, left out, so that nothing can spill; what they enclose is a
  // guess.
  std::uint32_t open_chains = 0;

  // Chains that were walked against their facets' winding, because nothing else closes them (turned facets).
  std::uint32_t turned_chains = 0;

  // Whether the contours are more than what the file says.
  [[nodiscard]] bool has_guesses() const { return open_chains > 0 || turned_chains > 0; }

  // A vertex in the middle of another facet's side lies beside it by a float's rounding, some nanometres,
  // which a flat slope makes wider. Of 0.1 um nobody would see anything.
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
