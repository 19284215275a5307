// The supports that are left when some of a plate's copies are no longer printed. Thread-safe (no shared
// state).
#pragma once

#include <memory>
#include <span>

#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {

// The rectangle that a copy covers as seen from above, in millimetres from the plate's centre.
struct CopyOutline {
  Point least{}, most{};
  bool is_printed = true;
};

// Returns the supports without those that lead only to copies that are no longer printed. Supports that are
// joined with those of another copy, or that lead to no copy, stay. The others stay as they are, bit by bit.
[[nodiscard]] std::shared_ptr<const SupportStructure> supports_of_printed(
    const SupportStructure& supports, std::span<const CopyOutline> copies);

}  // namespace contourd
