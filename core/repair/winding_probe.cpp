#include "core/repair/winding_probe.hpp"

#include <algorithm>
#include <cmath>

namespace contourd {
namespace {

// Limit on a grid's entries for each face: large faces lie over many cells.
constexpr std::int64_t kMaxEntriesAFace = 2;

using Coordinates = std::array<double, 3>;

Coordinates coordinates_of(const Vertex& v) {
  return {v.x, v.y, v.z};
}

struct Flat {
  double x, y;
};

// Returns how a line upwards from the point crosses the side: 1 if the side runs to the left there, -1 if to
// the right, 0 if the line misses it. Calculated from the side's end of lower x, so that both faces that
// share the side agree.
int passes_above(const Flat& from, const Flat& to, const Flat& point) {
  const bool rightwards = from.x < to.x;
  const Flat& left = rightwards ? from : to;
  const Flat& right = rightwards ? to : from;
  if (!(left.x <= point.x && point.x < right.x)) return 0;
  const double height = (right.x - left.x) * (point.y - left.y) - (right.y - left.y) * (point.x - left.x);
  if (!(height < 0)) return 0;
  return rightwards ? -1 : 1;
}

// Returns how often the triangle winds around the point, counter-clockwise: 1, 0 or -1.
int winding_of(const std::array<Flat, 3>& corners, const Flat& point) {
  return passes_above(corners[0], corners[1], point) + passes_above(corners[1], corners[2], point) +
         passes_above(corners[2], corners[0], point);
}

// The passage of a line along an axis through a facet.
struct Pass {
  int winding;  // 1: the line leaves the solid on its way up, -1: enters it, 0: misses the facet
  bool ahead;   // the facet is above the point that the line starts from
};

Pass pass_of(const Facet& facet, const Coordinates& at, std::size_t axis) {
  const std::size_t across = (axis + 1) % 3, along = (axis + 2) % 3;
  const Flat here{at[across], at[along]};
  std::array<Coordinates, 3> corners;
  std::array<Flat, 3> flat;
  for (std::size_t c = 0; c < 3; ++c) {
    corners[c] = coordinates_of(facet.vertices[c]);
    flat[c] = {corners[c][across], corners[c][along]};
  }
  const int winding = winding_of(flat, here);
  if (winding == 0) return {0, false};
  // The corners' heights, weighted by the areas opposite to them.
  double height = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const Flat &a = flat[(c + 1) % 3], &b = flat[(c + 2) % 3];
    height +=
        (corners[c][axis] - at[axis]) * ((a.x - here.x) * (b.y - here.y) - (b.x - here.x) * (a.y - here.y));
  }
  // A facet that the point itself lies on counts as ahead of it.
  return {winding, height * winding >= 0};
}

}  // namespace

WindingProbe::WindingProbe(std::span<const Facet> facets, std::span<const Face> faces)
    : facets_(facets), faces_(faces) {
  const Bounds bounds = bounds_of(facets);
  low_ = {bounds.min_x, bounds.min_y, bounds.min_z};
  high_ = {bounds.max_x, bounds.max_y, bounds.max_z};
  for (std::size_t axis = 0; axis < 3; ++axis)
    make_grid(axis);
}

template <typename Visit>
void WindingProbe::for_each_cell(const Grid& grid, const Face& face, Visit&& visit) const {
  const auto cells = [&](std::size_t axis, double low, double per_mm) {
    double least = HUGE_VAL, most = -HUGE_VAL;
    for (const Vertex& v : facets_[face.facet].vertices) {
      least = std::min(least, coordinates_of(v)[axis]);
      most = std::max(most, coordinates_of(v)[axis]);
    }
    const auto cell = [&](double at) {
      return std::clamp(static_cast<std::int64_t>((at - low) * per_mm), std::int64_t{0}, grid.cells - 1);
    };
    return std::pair(cell(least), cell(most));
  };
  const auto [left, right] = cells(grid.across, grid.low_across, grid.cells_across_mm);
  const auto [low, high] = cells(grid.along, grid.low_along, grid.cells_along_mm);
  visit(left, right, low, high);
}

// Chooses the number of cells: one for sixteen faces, or fewer if faces lie over many.
void WindingProbe::choose_cells(Grid& grid) const {
  const auto faces = static_cast<std::int64_t>(faces_.size());
  grid.cells = 1 + static_cast<std::int64_t>(std::sqrt(static_cast<double>(faces) / 16));
  for (;; grid.cells /= 2) {
    const auto cells_per_mm = [&](std::size_t axis) {
      const double size = high_[axis] - low_[axis];
      return size > 0 ? static_cast<double>(grid.cells) / size : 0.0;
    };
    grid.cells_across_mm = cells_per_mm(grid.across);
    grid.cells_along_mm = cells_per_mm(grid.along);
    std::int64_t entries = 0;
    for (const Face& face : faces_) {
      for_each_cell(grid, face, [&entries](auto left, auto right, auto low, auto high) {
        entries += (right - left + 1) * (high - low + 1);
      });
    }
    if (entries <= kMaxEntriesAFace * faces || grid.cells == 1) return;
  }
}

void WindingProbe::make_grid(std::size_t axis) {
  Grid& grid = grids_[axis];
  grid.across = (axis + 1) % 3;
  grid.along = (axis + 2) % 3;
  grid.low_across = low_[grid.across];
  grid.low_along = low_[grid.along];
  choose_cells(grid);
  grid.first.assign(static_cast<std::size_t>(grid.cells * grid.cells) + 1, 0);
  const auto each_entry = [&](auto&& visit) {
    for (std::uint32_t f = 0; f < faces_.size(); ++f) {
      for_each_cell(grid, faces_[f], [&](auto left, auto right, auto low, auto high) {
        for (auto row = low; row <= high; ++row) {
          for (auto column = left; column <= right; ++column)
            visit(static_cast<std::size_t>(row * grid.cells + column), f);
        }
      });
    }
  };
  each_entry([&grid](std::size_t cell, std::uint32_t) { ++grid.first[cell + 1]; });
  for (std::size_t cell = 1; cell < grid.first.size(); ++cell)
    grid.first[cell] += grid.first[cell - 1];
  grid.faces.resize(grid.first.back());
  std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
  each_entry([&](std::size_t cell, std::uint32_t face) { grid.faces[next[cell]++] = face; });
}

std::size_t WindingProbe::cell_under(const Grid& grid, const std::array<double, 3>& at) const {
  const auto cell = [&grid](double distance, double per_mm) {
    return std::clamp(static_cast<std::int64_t>(distance * per_mm), std::int64_t{0}, grid.cells - 1);
  };
  const std::int64_t column = cell(at[grid.across] - grid.low_across, grid.cells_across_mm);
  const std::int64_t row = cell(at[grid.along] - grid.low_along, grid.cells_along_mm);
  return static_cast<std::size_t>(row * grid.cells + column);
}

WindingProbe::Windings WindingProbe::windings_around(const SpacePoint& point,
                                                     const std::function<int(std::uint32_t)>& weight) {
  const Coordinates at{point.x, point.y, point.z};
  Windings windings{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Grid& grid = grids_[axis];
    const std::size_t cell = cell_under(grid, at);
    for (std::uint32_t i = grid.first[cell]; i < grid.first[cell + 1]; ++i) {
      ++looks_;
      const Pass pass = pass_of(facets_[faces_[grid.faces[i]].facet], at, axis);
      if (pass.winding == 0) continue;
      const int change = pass.winding * weight(grid.faces[i]);
      if (pass.ahead) {
        windings[2 * axis] += change;
      } else {
        windings[2 * axis + 1] -= change;
      }
    }
  }
  return windings;
}

}  // namespace contourd
