// Counts the supports of a print. Values; thread-safe (no shared state).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/support/supports.hpp"

namespace contourd {

// Counts of a print's contacts, branches and feet.
struct SupportCounts {
  std::size_t islands = 0, overhangs = 0, peel = 0;  // contacts by their cause
  std::size_t unheld = 0;                            // places that no support holds
  std::size_t over_gaps = 0;                         // overhangs that are left over narrow gaps
  std::uint32_t branches = 0, feet = 0, feet_on_models = 0;
  std::uint32_t carriers = 0;  // models that carry supports in their files
  double volume_mm3 = 0;

  [[nodiscard]] std::size_t contacts() const { return islands + overhangs + peel; }
  // True if any place has to be held.
  [[nodiscard]] bool any() const { return contacts() + unheld + over_gaps > 0; }
  bool operator==(const SupportCounts&) const = default;
};

// Returns the counts of the supports.
[[nodiscard]] inline SupportCounts counts_of(const Supports& supports) {
  const auto contacts = [&](ContactCause cause) {
    return static_cast<std::size_t>(std::ranges::count(supports.contacts, cause, &SupportContact::cause));
  };
  return {.islands = contacts(ContactCause::Island),
          .overhangs = contacts(ContactCause::Overhang),
          .peel = contacts(ContactCause::Peel),
          .unheld = supports.unheld.size(),
          .over_gaps = supports.over_gaps.size(),
          .branches = supports.branches,
          .feet = supports.feet,
          .feet_on_models = supports.feet_on_models,
          .carriers = supports.carriers,
          .volume_mm3 = supports.volume_mm3};
}

}  // namespace contourd
