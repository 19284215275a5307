// The slabs of a print, and how far resin flows in each. Thread-safe (no shared state).
#pragma once

#include <chrono>
#include <vector>

#include "core/cure/stop_check.hpp"
#include "core/engine/contour_engine.hpp"
#include "core/geometry/units.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// A slab, from the top of the slab beneath or from the plate.
struct RiseSlab {
  Nanometers top{};
  Millimeters distance{};  // for refill_speed(); infinity if a mask of the slab is not known
  bool operator==(const RiseSlab&) const = default;
};

struct SlabSettings {
  DisplayGeometry display{};
  Nanometers top{};        // the print's
  Nanometers thickness{};  // a slab's; the last has half more or less
  Micrometers growth{};    // Compensation::growth of the engine
  std::chrono::nanoseconds mask_budget{std::chrono::seconds{1}};
};

// Returns the thickness of the slabs of a print: a multiple of `layer`, at least `least` and 100 um, and at
// most about a thousand slabs. REQUIRES: positive lengths.
[[nodiscard]] Nanometers slab_thickness(Nanometers top, Nanometers layer, Micrometers least);

// Returns the slabs from the plate to the top. The distance of a slab holds for every height within it: its
// lit area is that of the mask at its lower end and of all facets within the slab, seen from above.
// Sections beside the models, such as supports, count at the slab's lower and upper end. Throws
// ComputationStopped. Blocks for a mask and some milliseconds a slab. REQUIRES: an engine with this display,
// at most 100,000 slabs.
[[nodiscard]] std::vector<RiseSlab> sweep_slabs(ContourEngine& engine, const SlabSettings& settings,
                                                StopCheck& stop);

}  // namespace contourd
