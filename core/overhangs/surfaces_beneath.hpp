// Finds the models' surface near the places that a sweep found: its exact height and the direction it faces.
// Pure functions, thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/engine/contour_engine.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// The range in which a surface is searched, on the plate.
struct SurfacePlace {
  Point at;
  double low_mm, high_mm;  // above the plate
  double reach_mm;         // horizontally
};
struct Surface {
  double z_mm;  // above the plate
  Direction outward;
};

// Returns for each place the lowest downward-facing surface within its heights and its reach, preferring one
// directly over the place; nullopt if there is none. Reads a model's facets once for each of its copies,
// however many places there are. REQUIRES: no null pointers; `display` is the display that the copies map to.
[[nodiscard]] std::vector<std::optional<Surface>> surfaces_beneath(std::span<const PlateModel> models,
                                                                   const DisplayGeometry& display,
                                                                   std::span<const SurfacePlace> places);

}  // namespace contourd
