// Counts how often a mesh winds around a point, by the facets that rays from the point pass through. Not
// thread-safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/geometry/facet.hpp"
#include "core/repair/facet_patches.hpp"

namespace contourd {

struct SpacePoint {
  double x, y, z;
};

class WindingProbe {
 public:
  // The winding numbers by the rays along x, y and z, up and down each.
  using Windings = std::array<int, 6>;

  // The facets and faces must outlive the probe.
  WindingProbe(std::span<const Facet> facets, std::span<const Face> faces);

  // Returns how often the faces wind around a point according to each ray. `weight(face)` is how often a face
  // counts, as its first facet is turned. The rays agree if the faces close.
  [[nodiscard]] Windings windings_around(const SpacePoint& point,
                                         const std::function<int(std::uint32_t)>& weight);

  // Returns the number of faces looked at in all: a measure of the time that the caller has spent on rays.
  [[nodiscard]] std::size_t looks() const { return looks_; }

 private:
  // Faces by the cells of a grid that they lie over, seen along an axis.
  struct Grid {
    std::size_t across, along;  // the axes of the grid
    double low_across, low_along, cells_across_mm, cells_along_mm;
    std::int64_t cells;  // along each axis of the grid
    std::vector<std::uint32_t> first, faces;
  };

  void make_grid(std::size_t axis);
  [[nodiscard]] std::size_t cell_under(const Grid& grid, const std::array<double, 3>& at) const;
  void choose_cells(Grid& grid) const;
  template <typename Visit>
  void for_each_cell(const Grid& grid, const Face& face, Visit&& visit) const;

  std::span<const Facet> facets_;
  std::span<const Face> faces_;
  std::array<double, 3> low_{}, high_{};
  std::array<Grid, 3> grids_;
  std::size_t looks_ = 0;
};

}  // namespace contourd
