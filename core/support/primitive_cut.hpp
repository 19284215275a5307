// Where a level plane cuts a support's primitive: a circle, or what a frustum's two end planes leave of an
// ellipse, a parabola or a hyperbola. Pure functions; thread-safe. By +, -, *, / and square roots alone: the
// same bits on every machine.
#pragma once

#include <optional>

#include "core/contour/conic_cut.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

// Above the plate, in millimetres. A plane at z cuts what has bottom <= z < top.
struct HeightReach {
  double bottom, top;
};
[[nodiscard]] HeightReach reach_of(const SupportPrimitive& primitive);

// The cut at a height above the plate in millimetres; nothing where there is none.
[[nodiscard]] std::optional<ConicCut> cut_at(const SupportPrimitive& primitive, double z_mm);

}  // namespace contourd
