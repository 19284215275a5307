#include "core/height_index.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace contourd {
namespace {

// Cells on the deepest level: enough to tell a 200 mm model's 3 um layers apart; 2^17 cells in all are 512
// KiB.
constexpr std::size_t kDeepestLevelLimit = 16;

// A facet must be shorter than its cell by this factor, so that the rounding in cell_of() (a few units in the
// 16th digit, times up to 2^16 cells) cannot place its ends two cells apart.
constexpr double kCellMargin = 1.0 + 1e-9;

struct HeightRange {
  double low, high;
};

HeightRange height_range(const Facet& facet) {
  const auto [a, b, c] = facet.vertices;
  return {std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z})};
}

}  // namespace

HeightIndex::HeightIndex(std::vector<Facet> facets)
    : facets_(std::move(facets)), bounds_(bounds_of(facets_)) {
  make_levels();
  if (!levels_.empty()) sort_into_cells();
}

void HeightIndex::make_levels() {
  const double height = bounds_.size_z();
  if (!(height > 0.0)) return;
  // No more cells than facets on the deepest level: they would be empty.
  const std::size_t deepest =
      std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(facets_.size())), kDeepestLevelLimit);
  std::size_t first_cell = 0;
  for (std::size_t level = 0; level <= deepest; ++level) {
    const std::size_t cells = std::size_t{1} << level;
    levels_.push_back({first_cell, cells, static_cast<double>(cells) / height});
    first_cell += cells;
  }
  cell_starts_.assign(first_cell + 1, 0);
}

std::size_t HeightIndex::cell_of(const Facet& facet) const {
  const auto [low, high] = height_range(facet);
  const double reach = (high - low) * kCellMargin;
  std::size_t level = levels_.size() - 1;
  if (reach > 0.0) {
    // The deepest k with 2^k <= H / reach.
    const int exponent = std::ilogb(bounds_.size_z() / reach);
    level = std::min(level, static_cast<std::size_t>(std::max(exponent, 0)));
  }
  return levels_[level].first_cell + cell_of(low, levels_[level]);
}

void HeightIndex::sort_into_cells() {
  // Counting sort: how many facets a cell has, where each cell starts, then each facet to its place.
  for (const Facet& facet : facets_)
    ++cell_starts_[cell_of(facet) + 1];
  for (std::size_t cell = 1; cell < cell_starts_.size(); ++cell)
    cell_starts_[cell] += cell_starts_[cell - 1];
  std::vector<std::uint32_t> next(cell_starts_.begin(), cell_starts_.end() - 1);
  std::vector<std::uint32_t> place(facets_.size());
  for (std::size_t i = 0; i < facets_.size(); ++i)
    place[i] = next[cell_of(facets_[i])]++;
  // Follows the permutation's cycles, so that no second copy of the facets is needed.
  for (std::uint32_t i = 0; i < place.size(); ++i) {
    while (place[i] != i) {
      const std::uint32_t target = place[i];
      std::swap(facets_[i], facets_[target]);
      std::swap(place[i], place[target]);
    }
  }
}

}  // namespace contourd
