// Supports as facets, for programs that know no primitives: each primitive a closed mesh of its own, which
// lie in each other as the primitives do. Pure; thread-safe. The same on every machine.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

// In the plate's millimetres, counter-clockwise seen from outside. Corners are on the primitives' surfaces,
// facets at most kMeshErrorMm within; of radii over 100 mm more, since a ring has at most 96 sides. A ball
// without a radius has none.
inline constexpr double kMeshErrorMm = 0.02;
[[nodiscard]] std::vector<Facet> support_mesh(std::span<const SupportPrimitive> primitives);

}  // namespace contourd
