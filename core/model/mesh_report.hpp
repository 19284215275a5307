// A report of what is right and wrong with a model's mesh. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

// The volume that a model's facets enclose.
struct EnclosedVolume {
  double mm3 = 0;  // negative if the facets face inwards
  // How much mm3 depends on the point that it is calculated from, over all points of the model's bounds; 0,
  // but for rounding, if the facets close.
  double uncertainty_mm3 = 0;

  // True if the volume is negative even when gaps between the facets are taken into account.
  [[nodiscard]] bool inside_out() const { return mm3 < -uncertainty_mm3; }
};

// Adds up the tetrahedra of all facets from a point of the model, which keeps the digits of small models far
// from (0, 0, 0).
[[nodiscard]] EnclosedVolume enclosed_volume(std::span<const Facet> facets, const Bounds& bounds);

// Two vertices are the same if their coordinates are equal, bit for bit (-0 and 0 alike). Edge figures leave
// out degenerate facets.
struct MeshReport {
  std::uint64_t facets = 0;
  Bounds bounds;
  double volume_mm3 = 0;                 // signed: negative if the facets face inwards
  bool inside_out = false;               // a print turns the facets
  std::uint64_t degenerate_facets = 0;   // two equal vertices
  std::uint64_t zero_area_facets = 0;    // degenerate ones included
  std::uint64_t duplicate_facets = 0;    // facets over the same three vertices as an earlier one
  std::uint64_t open_edges = 0;          // edges of one facet only
  std::uint64_t non_manifold_edges = 0;  // edges of more than two facets
  std::uint64_t flipped_edges = 0;       // edges of two facets that are wound against each other
  std::uint64_t parts = 0;               // parts of the mesh that share no vertex
  // Every edge is shared by an even number of facets, half of them in each direction; and there is at least
  // one facet.
  bool watertight = false;
};

// Inspects a mesh. Takes time and memory in proportion to the number of facets (about 100 bytes each).
[[nodiscard]] MeshReport inspect_mesh(std::span<const Facet> facets);

}  // namespace contourd
