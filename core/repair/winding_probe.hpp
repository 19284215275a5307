// How often a mesh winds around a point, by counting what rays from there pass through. Not thread-safe.
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
  // Along x, y and z, up and down.
  using Windings = std::array<int, 6>;

  // The facets and faces must outlive the probe.
  WindingProbe(std::span<const Facet> facets, std::span<const Face> faces);

  // What the rays from a point say that the faces wind around it; `weight(face)` tells how often a face
  // counts, as its first facet is turned. They agree where the faces close.
  [[nodiscard]] Windings windings_around(const SpacePoint& point,
                                         const std::function<int(std::uint32_t)>& weight);

  // How many faces it has looked at in all: a caller's measure for how long this may take.
  [[nodiscard]] std::size_t looks() const { return looks_; }

 private:
  // Faces by the cells that they lie over, seen along an axis.
  struct Grid {
    std::size_t across, along;  // the axes that the cells lie on
    double low_across, low_along, cells_across_mm, cells_along_mm;
    std::int64_t cells;  // a side
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
