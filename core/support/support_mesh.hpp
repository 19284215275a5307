// Supports as facets, for programs that know no primitives. Each primitive becomes a closed mesh of its own,
// and the meshes overlap as the primitives do. Pure; thread-safe. The same on every machine.
#pragma once

#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/support/support_primitive.hpp"

namespace contourd {

// How far a facet lies inside the primitive's surface at most, for radii up to 100 mm: beyond that the error
// is larger, since a ring has at most 96 sides.
inline constexpr double kMeshErrorMm = 0.02;
// Returns the facets in millimetres from the plate's centre, counter-clockwise as seen from outside, their
// corners on the primitives' surfaces. A ball without a radius has no facets. A primitive that reaches below
// the plate, as a slanted branch beside its foot does, ends there in a flat face: other programs would lay
// their lowest point on the plate, and all other feet would hang in the air.
[[nodiscard]] std::vector<Facet> support_mesh(std::span<const SupportPrimitive> primitives);

}  // namespace contourd
