#include "core/model/height_index.hpp"

#include <bit>
#include <utility>

#include "core/model/mesh_report.hpp"
#include "core/repair/mesh_soundness.hpp"

namespace contourd {
namespace {

// Cells on the deepest level: enough to tell a 200 mm model's 3 um layers apart; 2^17 cells in all are 512
// KiB.
constexpr std::size_t kDeepestLevelLimit = 16;

// A facet must be shorter than its cell by this factor, so that the rounding in cell_of() (a few units in the
// 16th digit, times up to 2^16 cells) cannot place its ends two cells apart.
constexpr double kCellMargin = 1.0 + 1e-9;

// Returns the largest k with 2^k * part < 1, up to 1022; more if part is 0. REQUIRES: 0 <= part, and not much
// above 1.
std::size_t halvings_above(double part) {
  expects_costly([&] { return part >= 0; }, "the part is not negative");
  constexpr int kFractionBits = 52;
  constexpr std::uint64_t kBias = 1023;
  const std::uint64_t exponent = std::bit_cast<std::uint64_t>(part) >> kFractionBits;
  return exponent < kBias ? static_cast<std::size_t>(kBias - 1 - exponent) : 0;
}

}  // namespace

HeightIndex::HeightIndex(std::vector<Facet> facets)
    : facets_(std::move(facets)), bounds_(bounds_of(facets_)) {
  expects(facets_.size() < kMaxFacets, "there are fewer than 2^30 facets");
  expects_costly([this] { return std::ranges::all_of(facets_, is_finite); }, "all coordinates are finite");
  if (enclosed_volume(facets_, bounds_).inside_out()) turn_outwards();
  if (!is_sound(facets_)) repairs_ = repair_mesh(facets_);
  make_levels();
  sort_into_cells();
  find_uneven_faces();
}

void HeightIndex::turn_outwards() {
  for (Facet& facet : facets_)
    std::swap(facet.vertices[1], facet.vertices[2]);
  turned_outwards_ = true;
}

void HeightIndex::make_levels() {
  const double height = bounds_.size_z();
  cell_starts_.assign(2, 0);
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

std::size_t HeightIndex::cell_of(float low, float high) const {
  const Level& level = level_of(static_cast<double>(high) - static_cast<double>(low));
  return level.first_cell + cell_of(low, level);
}

const HeightIndex::Level& HeightIndex::level_of(double reach) const {
  const double part_of_height = reach * kCellMargin * levels_[0].cells_per_mm;
  return levels_[std::min(levels_.size() - 1, halvings_above(part_of_height))];
}

void HeightIndex::sort_into_cells() {
  // Counting sort: count the facets of each cell, find where each cell starts, then put each facet in its
  // place.
  std::vector<std::uint32_t> cells(facets_.size());
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    const auto [low, high] = heights_of(facets_[i]);
    const std::size_t cell = levels_.empty() ? 0 : cell_of(low, high);
    cells[i] = static_cast<std::uint32_t>(cell);
    ++cell_starts_[cell + 1];
  }
  for (std::size_t cell = 1; cell < cell_starts_.size(); ++cell)
    cell_starts_[cell] += cell_starts_[cell - 1];
  std::vector<std::uint32_t> next(cell_starts_.begin(), cell_starts_.end() - 1);
  candidates_.resize(facets_.size());
  for (std::size_t i = 0; i < facets_.size(); ++i) {
    const auto [low, high] = heights_of(facets_[i]);
    candidates_[next[cells[i]]++] = {low, high, static_cast<std::uint32_t>(i)};
  }
}

void HeightIndex::find_uneven_faces() {
  if (levels_.empty()) return;
  UnevenFaces::Collector collector(bounds_);
  // Facets that may be level lie on the deepest levels, whose candidates are the last ones.
  const Level& level = level_of(std::min(double{collector.rounding_mm()}, bounds_.size_z()));
  for (const Candidate& each : std::span(candidates_).subspan(cell_starts_[level.first_cell]))
    collector.add(facets_[each.facet], {each.low, each.high});
  uneven_faces_ = collector.take();
}

}  // namespace contourd
