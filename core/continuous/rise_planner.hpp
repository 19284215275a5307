// Plans the rises of a whole print. Pure functions; thread-safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/continuous/rise_laws.hpp"
#include "core/continuous/rise_plan.hpp"
#include "core/continuous/slab_sweep.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// The plate does not rise by less, unless after a rest within a rise.
inline constexpr Nanometers kLowestRise{1'000'000};

// Bounds on the speed of a print's rises.
struct RiseBounds {
  LitResin lit{};
  double margin = 0;  // at least, of the dose
  RefillingResin refill{};
  MillimetersPerSecond fastest{};  // of the machine
  MillimetersPerSecond slowest{};  // where the laws ask for less, the print is layered
  MillimetersPerSecondSquared acceleration{};
  std::chrono::duration<double> window{};  // light at a time, after which the window's oxygen is used up
  Nanometers travel{std::numeric_limits<std::int64_t>::max()};  // the plate rises no higher
};

// Returns the rises of a print from a height on, from the plate up. Between the top of one and the bottom of
// the next the print is layered; where they are at the same height, the plate rests in the dark until the
// window has its oxygen again. Rises are at least a millimetre high, unless such a rest makes them lower, and
// begin and end between slabs.
//
// The masks are those of the height at which resin gels, see GelFront. So the plate goes on above the top of
// a rise, by the widest gap that its last speeds leave, or to the end of its travel.
//
// Each slab is passed at the speed of the strictest law in it and in the slab beneath, whose sections are
// still lit. With light that is always on, the gap that resin flows through depends on the speeds since resin
// entered it, which is less than a slab ago: faster than before, resin has to flow through the narrow gap of
// the slower speed. So a rise starts as the dead zone alone allows, and speeds up from slab to slab.
// REQUIRES: slabs of sweep_slabs() at least as thick as gel_gap() at the margin, and the last of 1 um; bounds
// of positive values, margin > 1.
[[nodiscard]] std::vector<RisePlan> plan_rises(std::span<const RiseSlab> slabs, Nanometers from,
                                               const RiseBounds& bounds);

// A rise whose bounds change before it or while it is under way.
struct RiseChange {
  RisePlan before{};  // the whole rise by the bounds before
  Nanometers from{};  // up to here, the plate does not rise faster than it did
  double light = 1;   // irradiance over that of the bounds before
};

struct ChangedRise {
  RisePlan plan;
  // The slowest speed above RiseChange::from, but for ramps, and the height from which on it holds.
  MillimetersPerSecond slowest{};
  Nanometers slowest_at{};
};

// Returns the rise from the same bottom to the same top by other bounds, whose slowest speed and window are
// not kept. Above `from`, resin flows through the gap that the speeds and the light before have left.
// REQUIRES: the slabs of sweep_slabs() by which the rise was planned; bounds as for plan_rises(), but for
// the slabs' thickness; a light above 0.
[[nodiscard]] ChangedRise change_rise(std::span<const RiseSlab> slabs, const RiseChange& change,
                                      const RiseBounds& bounds);

}  // namespace contourd
