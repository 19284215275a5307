// Turns and scales a model before it is sliced. Thread-safe (no shared state).
#pragma once

#include <span>

#include "core/facet.hpp"

namespace contourd {

// Rotations in degrees about the fixed axes x, then y, then z (right-handed); then the scale factor.
struct Orientation {
  double x_deg = 0, y_deg = 0, z_deg = 0;
  double scale = 1.0;

  [[nodiscard]] bool is_identity() const { return x_deg == 0 && y_deg == 0 && z_deg == 0 && scale == 1.0; }
};

// Applies it to every vertex, in double, rounded to float once. Equal vertices stay equal, so closed models
// stay closed. Quarter turns are exact. Coordinates must stay within float's range (the caller checks bounds
// and scale).
void orient(std::span<Facet> facets, const Orientation& orientation);

}  // namespace contourd
