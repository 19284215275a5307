// The primitives that supports are made of: frustums and balls, cut exactly at any height, never a mesh.
// Values; thread-safe as any value is.
#pragma once

#include <optional>
#include <variant>

#include "core/contour/conic_cut.hpp"
#include "core/support/support_contact.hpp"

namespace contourd {

// A right circular cone truncated by two flat ends; a cylinder if both radii are equal.
struct Frustum {
  PlatePoint lower, upper;  // middles of its ends; lower.z <= upper.z, and not the same point
  double lower_radius_mm = 0, upper_radius_mm = 0;
  bool operator==(const Frustum&) const = default;
};

struct Ball {
  PlatePoint center;
  double radius_mm = 0;
  bool operator==(const Ball&) const = default;
};

using SupportPrimitive = std::variant<Frustum, Ball>;

// The heights that a primitive spans, in millimetres above the plate. A plane at z cuts it if bottom <= z <
// top.
struct HeightReach {
  double bottom, top;
};
[[nodiscard]] HeightReach reach_of(const SupportPrimitive& primitive);

// Returns the exact section at a height in millimetres above the plate: a circle, or an ellipse, parabola or
// hyperbola clipped by the frustum's two end planes; nullopt if the plane misses the primitive. Uses only +,
// -,
// *, / and square roots: the same bits on every machine.
[[nodiscard]] std::optional<ConicCut> cut_at(const SupportPrimitive& primitive, double z_mm);

}  // namespace contourd
