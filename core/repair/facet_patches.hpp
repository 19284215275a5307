// A mesh split into patches at its open and its non-manifold edges. Values; thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/geometry/vertex_numbers.hpp"

namespace contourd {

// Facets over the same three vertices, however they are turned.
struct Face {
  Corners corners;
  std::uint32_t facet;   // the first of them
  std::int16_t net;      // how many are turned as the first is, less those that are turned the other way
  std::uint16_t copies;  // how many there are
};

// Where a face belongs to.
struct FacePlace {
  std::uint32_t patch : 31;
  std::uint32_t reversed : 1;  // whether its first facet is turned against the patch
};

// Faces that meet over edges of exactly two faces.
struct Patch {
  std::uint32_t faces = 0, first_face = 0;
  std::uint32_t boundary_edges = 0;  // sides that no other face shares
  bool orientable = true;            // whether its faces can be turned alike
  // By its faces' net, as the patch is turned: the least, the most, and how many have which, from -kMaxNet
  // or less to kMaxNet or more.
  static constexpr std::int32_t kMaxNet = 3;
  std::int32_t least_net = 0, most_net = 0;
  std::array<std::uint32_t, 2 * kMaxNet + 1> with_net{};
  std::int64_t net = 0;                       // all together
  std::uint16_t most_copies = 0;              // facets of one face
  std::uint32_t odd = 0;                      // faces of an odd number of facets
  std::uint32_t odd_half = 0;                 // faces of twice an odd number of facets
  double area = 0;                            // square millimetres, as all of these
  double six_volumes = 0;                     // of the tetrahedra from the bounds' centre
  double area_x = 0, area_y = 0, area_z = 0;  // twice the areas as a vector

  [[nodiscard]] static std::size_t place_of(std::int32_t some_net) {
    return static_cast<std::size_t>(std::clamp(some_net, -kMaxNet, kMaxNet)) + kMaxNet;
  }
  // Whether the file has the same number of facets of each face, turned alike.
  [[nodiscard]] bool is_even() const { return orientable && least_net == most_net; }
};

// A patch's part in a junction, an edge of more than two faces: how many of its sides run there from the
// lower vertex to the higher, less those that run back.
struct JunctionPart {
  std::uint32_t junction, patch;
  std::int32_t sides;
};

struct BoundaryEdge {
  std::uint32_t face;
  std::uint32_t from, to;  // vertices, as the face's first facet runs
};

struct FacetPatches {
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  std::vector<std::uint32_t> face_of;  // by facet; kNone where two vertices are the same
  std::vector<Face> faces;
  std::vector<FacePlace> places;             // by face
  std::vector<Patch> patches;                // by their first face
  std::vector<JunctionPart> junction_parts;  // by junction; parts of no sides are left out
  std::uint32_t junctions = 0;
  std::vector<BoundaryEdge> boundary_edges;
};

// Takes time and memory in proportion to the number of facets (about 50 bytes each).
[[nodiscard]] FacetPatches patches_of(std::span<const Facet> facets);

}  // namespace contourd
