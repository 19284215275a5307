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

// All facets over the same three vertices, in either orientation.
struct Face {
  Corners corners;
  std::uint32_t facet;   // number of the first of these facets
  std::int16_t net;      // facets turned like the first minus facets turned the other way
  std::uint16_t copies;  // number of facets
};

// The patch of a face, and the face's orientation in the patch.
struct FacePlace {
  std::uint32_t patch : 31;
  std::uint32_t reversed : 1;  // 1: the face's first facet is turned against the patch
};

// Faces that are connected by edges of exactly two faces.
struct Patch {
  std::uint32_t faces = 0, first_face = 0;
  std::uint32_t boundary_edges = 0;  // edges that no other face shares
  bool orientable = true;            // all of its faces can be turned alike
  // The faces' nets, as the patch is turned: the least, the most, and how many faces have each net from
  // -kMaxNet or less to kMaxNet or more.
  static constexpr std::int32_t kMaxNet = 3;
  std::int32_t least_net = 0, most_net = 0;
  std::array<std::uint32_t, 2 * kMaxNet + 1> with_net{};
  std::int64_t net = 0;           // the sum over all faces
  std::uint16_t most_copies = 0;  // the most facets of one face
  std::uint32_t odd = 0;          // faces with an odd number of facets
  std::uint32_t odd_half = 0;     // faces with twice an odd number of facets
  double area = 0;                // in square millimetres
  double six_volumes = 0;         // sum of the tetrahedra from the bounds' centre, in cubic millimetres
  double area_x = 0, area_y = 0, area_z = 0;  // twice the faces' areas, added as vectors

  [[nodiscard]] static std::size_t place_of(std::int32_t some_net) {
    return static_cast<std::size_t>(std::clamp(some_net, -kMaxNet, kMaxNet)) + kMaxNet;
  }
  // True if the file has each face equally often, with all facets turned alike.
  [[nodiscard]] bool is_even() const { return orientable && least_net == most_net; }
};

// A patch's part in a junction (an edge of more than two faces): the number of its sides that run from the
// lower vertex to the higher, minus those that run back.
struct JunctionPart {
  std::uint32_t junction, patch;
  std::int32_t sides;
};

struct BoundaryEdge {
  std::uint32_t face;
  std::uint32_t from, to;  // vertices, in the direction of the face's first facet
};

struct FacetPatches {
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  std::vector<std::uint32_t> face_of;  // by facet; kNone if two of its vertices are the same
  std::vector<Face> faces;
  std::vector<FacePlace> places;             // by face
  std::vector<Patch> patches;                // in the order of their first faces
  std::vector<JunctionPart> junction_parts;  // by junction; parts of 0 sides are left out
  std::uint32_t junctions = 0;
  std::vector<BoundaryEdge> boundary_edges;
};

// Splits a mesh into patches. Takes time and memory in proportion to the number of facets (about 50 bytes
// each).
[[nodiscard]] FacetPatches patches_of(std::span<const Facet> facets);

}  // namespace contourd
