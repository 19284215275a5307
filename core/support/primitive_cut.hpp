// The exact section of a support primitive in a horizontal plane: a circle, or an ellipse, parabola or
// hyperbola clipped by the frustum's two end planes. Pure functions; thread-safe. Uses only +, -, *, / and
// square roots: the same bits on every machine.
#pragma once

#include <optional>

#include "core/contour/conic_cut.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

// The heights that a primitive spans, in millimetres above the plate. A plane at z cuts it if bottom <= z <
// top.
struct HeightReach {
  double bottom, top;
};
[[nodiscard]] HeightReach reach_of(const SupportPrimitive& primitive);

// Returns the section at a height in millimetres above the plate; nullopt if the plane misses the primitive.
[[nodiscard]] std::optional<ConicCut> cut_at(const SupportPrimitive& primitive, double z_mm);

}  // namespace contourd
