// A model's facets in the form in which directions are rated: every vertex once, facets' areas as vectors,
// and vertices grouped by cells. Immutable once built; thread-safe.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/geometry/vertex_numbers.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"

namespace contourd {

[[nodiscard]] inline double dot(const Direction& a, const Direction& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

[[nodiscard]] inline double length_of(const Direction& v) {
  return std::sqrt(dot(v, v));
}

// Returns a vector along the facet's normal, as long as the facet's area in mm2.
[[nodiscard]] inline Direction area_of(const Facet& facet) {
  const auto& [a, b, c] = facet.vertices;
  const double ax = a.x, ay = a.y, az = a.z;
  const double ux = b.x - ax, uy = b.y - ay, uz = b.z - az;
  const double vx = c.x - ax, vy = c.y - ay, vz = c.z - az;
  return {(uy * vz - uz * vy) / 2, (uz * vx - ux * vz) / 2, (ux * vy - uy * vx) / 2};
}

// Facets that represent a whole model: each weight is the number of times that the facet's own area counts.
struct FacetSample {
  std::vector<Facet> facets;
  std::vector<double> weights;
};
// Takes a sample of at most `most` facets, each for an equal part of the surface, including all facets that
// are larger than such a part: walks along the model's surface, and takes the facet that completes a part.
// `exposed`: by facet, the part of its area that counts; if empty, all of it. REQUIRES: most > 0.
[[nodiscard]] FacetSample sample_of(std::span<const Facet> facets, std::span<const double> exposed,
                                    std::size_t most);

class RatedMesh {
 public:
  // A facet as it is rated.
  struct Side {
    Corners corners;  // numbers of vertices
    float x, y, z;    // vector outwards, as long as the area in mm2
    float size;       // the area in mm2
    bool keep_clean = false;
    bool hidden = false;  // lies within another body: its weight is 0

    // Returns the area seen along a direction of length 1; below 0 if the facet looks the other way.
    [[nodiscard]] double along(const Direction& up) const { return up.x * x + up.y * y + up.z * z; }
  };

  // `weights`: by facet; if empty, each facet counts once. `cell_mm`: the size of the cubes of cell_of().
  struct Making {
    std::span<const Facet> facets;
    std::span<const double> weights{};
    double cell_mm = 1;
    std::span<const KeepClean> keep_clean{};
  };
  // Builds the mesh; takes 60 bytes a facet. REQUIRES: a weight for each facet if there are any; cell_mm > 0.
  explicit RatedMesh(const Making& making);

  [[nodiscard]] std::span<const Vertex> vertices() const { return vertices_; }
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }
  // Returns the cube that a vertex lies in, of a grid of cubes; cubes with vertices are numbered from 0.
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
