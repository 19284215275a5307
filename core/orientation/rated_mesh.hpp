// A model's facets as directions are rated by: every vertex once, facets' areas as vectors, and what belongs
// together. Immutable once built; thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/geometry/vertex_numbers.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd {

// Facets that stand for a model's: each with how many times its own area.
struct FacetSample {
  std::vector<Facet> facets;
  std::vector<double> weights;
};
// At most `most` of them, each for as large a part of the surface, and all that are larger than such a part:
// the model's surface is walked along, and where a part of it is full, the facet that fills it is taken.
// REQUIRES: most > 0.
[[nodiscard]] FacetSample sample_of(std::span<const Facet> facets, std::size_t most);

class RatedMesh {
 public:
  // A facet.
  struct Side {
    Corners corners;  // numbers of vertices
    float x, y, z;    // outwards, as long as its area in mm2
    float size;       // that length
    bool keep_clean = false;

    // Of its area, seen along a direction of length 1; below 0 where it looks the other way.
    [[nodiscard]] double along(const Direction& up) const { return up.x * x + up.y * y + up.z * z; }
  };

  // `weights` by facet, or none: each counts once. `inside_out`: the facets face inwards. `cell_mm`: see
  // cell_of().
  struct Making {
    std::span<const Facet> facets;
    std::span<const double> weights{};
    bool inside_out = false;
    double cell_mm = 1;
    std::span<const KeepClean> keep_clean{};
  };
  // Takes 60 bytes a facet. REQUIRES: a weight for each facet if there are any; cell_mm > 0.
  explicit RatedMesh(const Making& making);

  [[nodiscard]] std::span<const Vertex> vertices() const { return vertices_; }
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }
  // In which cube a vertex lies, of a grid of such cubes; those with vertices are numbered from 0.
  [[nodiscard]] std::uint32_t cell_of(std::uint32_t vertex) const { return cells_[vertex]; }
  [[nodiscard]] std::uint32_t cells() const { return cell_count_; }

 private:
  void number_cells(double cell_mm);

  std::vector<Vertex> vertices_;
  std::vector<Side> sides_;
  std::vector<std::uint32_t> cells_;  // by vertex
  std::uint32_t cell_count_ = 0;
};

}  // namespace contourd
