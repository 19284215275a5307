// Finds the models' surface near places that a sweep found: its exact height, and which way it looks. Pure
// functions, thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// Where a surface is looked for, on the plate.
struct SurfacePlace {
  Point at;
  double low_mm, high_mm;  // above the plate
  double reach_mm;         // aside
};
struct Surface {
  double z_mm;  // above the plate
  Direction outward;
};

// For each place the undermost surface over or beside it that looks down, within its heights and its reach;
// right over it where there is one. Nothing where there is none. Passes over a model's facets once for each
// of its copies, whatever the number of places. REQUIRES: no null pointers; `display` is what the copies map
// to.
[[nodiscard]] std::vector<std::optional<Surface>> surfaces_beneath(std::span<const PlateModel> models,
                                                                   const DisplayGeometry& display,
                                                                   std::span<const SurfacePlace> places);

}  // namespace contourd
