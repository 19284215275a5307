// Finds the shells of a model whose winding contradicts their place: a print fills or hollows them otherwise
// than they were probably meant. Pure, thread-safe.
#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/facet.hpp"

namespace contourd {

// A shell is a part of the mesh that is connected over edges of two facets.
struct ShellReport {
  // Shells that face inwards but lie outside all solids, or reach out of them. Where such a shell overlaps
  // a solid, the two cancel each other; elsewhere it is filled.
  std::uint64_t inside_out = 0;
  Vertex inside_out_at{};  // a vertex of the first such shell
  // Shells that face outwards but lie within a solid, where they change nothing. Not counted if any shells of
  // the model reach into each other, because bodies within bodies are then meant.
  std::uint64_t within = 0;
  Vertex within_at{};

  // Shells that face inwards, as a cavity does, but where solids overlap: one of the solids fills the cavity,
  // or a large part of it.
  std::uint64_t filled = 0;
  Vertex filled_at{};

  [[nodiscard]] bool any() const { return inside_out > 0 || within > 0 || filled > 0; }
  bool operator==(const ShellReport&) const = default;
};

// Inspects the shells of a model whose facets have been repaired. Takes about as much time and memory as
// repair_mesh(). Shells that rays do not reach within that time count as right. REQUIRES: finite coordinates,
// fewer than 2^30 facets.
[[nodiscard]] ShellReport inspect_shells(std::span<const Facet> facets);

}  // namespace contourd
