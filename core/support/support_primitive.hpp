// The primitives that supports are made of: frustums and balls, cut exactly at any height, never a mesh.
// Values; thread-safe as any value is.
#pragma once

#include <variant>

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

}  // namespace contourd
