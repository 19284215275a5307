// Cuts facets by the slicing plane: the thesis's algorithm 1, steps 2 to 12.
//
// The thesis distinguishes six cases of facet and plane (table 3.1) and repairs the bad ones afterwards
// (caseHandler). Here a single rule leaves two cases: a vertex is above the plane if its z > z_slice; a
// vertex at exactly z_slice is below. A facet with one or two vertices above is crossed through exactly two
// sides; any other is not crossed.
//
//   case  by the thesis                           here
//   I     a side lies in the plane                crossed at its ends if the third vertex is above, else not
//   II    through a vertex and the opposite side  crossed; one of the two points is that vertex
//   III   through two sides                       crossed
//   IV    no intersection                         not crossed
//   V     touches in one vertex                   not crossed, or a segment of no length, which is dropped
//   VI    parallel, in the plane                  not crossed
//
// The result is the section just above z_slice, so a plane in a flat face gives the face's solid side once.
// In a flat face that rounding has made uneven, z_slice is the face's highest vertex (see UnevenFaces).
#pragma once

#include <cstdint>
#include <vector>

#include "core/contour/segment_ends.hpp"
#include "core/contract/expects.hpp"
#include "core/geometry/units.hpp"
#include "core/model/height_index.hpp"

namespace contourd {

struct Section {
  std::vector<Segment> segments;
  // The number of facets that the plane crosses (the thesis's IF, table 4.3), including zero-length cuts.
  std::uint32_t intersecting_facets = 0;
  // True if as many segments start as end at every point, so that they form closed loops without any repair.
  bool balanced = true;
};

// Finds the section at z in the model's own coordinates, replacing the contents of `section`. Allocates only
// while section.segments grows.
void slice_at(const HeightIndex& model, Millimeters z, Section& section);

// Returns the point where the side from `lower` to `upper` meets the plane: the thesis's equations 3.1 to 3.5
// with n = (0, 0, 1), which leave s = (z - lower.z) / (upper.z - lower.z). Always calculated from the lower
// end to the upper, so that both facets that share a side compute the same bits and their segments meet
// without a tolerance. REQUIRES: lower.z <= z < upper.z.
[[nodiscard]] inline Point intersect_side(const Vertex& lower, const Vertex& upper, double z) {
  expects_costly([&] { return lower.z <= z && z < upper.z; }, "the side crosses the plane");
  const double lower_x = lower.x, lower_y = lower.y, lower_z = lower.z;
  const double s = (z - lower_z) / (static_cast<double>(upper.z) - lower_z);
  return {lower_x + s * (static_cast<double>(upper.x) - lower_x),
          lower_y + s * (static_cast<double>(upper.y) - lower_y)};
}

}  // namespace contourd
