#include "core/continuous/slab_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "core/continuous/refill_distance.hpp"
#include "core/continuous/slab_facets.hpp"
#include "core/contract/expects.hpp"
#include "core/peel/lit_cells.hpp"

namespace contourd {
namespace {

constexpr std::int64_t kMostSlabs = 100'000;

// Returns the cells of the mask at a height; nullopt if it takes too long.
std::optional<LitCells> cells_at(ContourEngine& engine, Nanometers height, const SlabSettings& settings) {
  MaskBudget budget(MaskBudget::Clock::now() + settings.mask_budget);
  if (engine.mask_within(height, budget) == nullptr) return std::nullopt;
  const Mask& coverage = engine.coverage();
  return LitCells(coverage, refill_cells(coverage.width(), coverage.height()));
}

// Returns the cells that are lit somewhere in a slab, by those at its ends and the facets within.
LitCells cells_within(const ContourEngine& engine, const SlabSettings& settings, HeightSpan span,
                      LitCells lower, const LitCells& upper, StopCheck& stop) {
  for (std::size_t cell = 0; cell < upper.size(); ++cell)
    if (upper.is_lit(cell)) lower.light(cell);
  const std::int32_t side = refill_cells(settings.display.width, settings.display.height).side;
  const double growth_pixels = settings.growth / settings.display.pixel_pitch;
  for (const PlateModel& model : engine.models())
    light_facets(model, span, {side, std::max(growth_pixels, 0.0) / side}, lower, stop);
  return lower;
}

}  // namespace

Nanometers slab_thickness(Nanometers top, Nanometers layer, Micrometers least) {
  expects(top > Nanometers{} && layer > Nanometers{} && least > Micrometers{}, "slabs are of a print");
  constexpr std::int64_t kMany = 1000, kLeastNm = 100'000;
  const std::int64_t thickness =
      std::max({kLeastNm, top.count() / kMany, static_cast<std::int64_t>(std::ceil(least.count() * 1000))});
  return layer * ((thickness + layer.count() - 1) / layer.count());
}

std::vector<RiseSlab> sweep_slabs(ContourEngine& engine, const SlabSettings& settings, StopCheck& stop) {
  expects(settings.thickness > Nanometers{} && settings.top / settings.thickness <= kMostSlabs,
          "a print has at most 100,000 slabs");
  const CellRule rule = refill_cells(settings.display.width, settings.display.height);
  RefillDistance distance(to_millimeters(settings.display.pixel_pitch) * rule.side);
  std::vector<RiseSlab> slabs;
  std::optional<LitCells> lower = cells_at(engine, Nanometers{}, settings);
  for (Nanometers bottom{}; bottom < settings.top;) {
    // A thin rest belongs to the last slab.
    const bool is_last = settings.top - bottom < settings.thickness * 3 / 2;
    const Nanometers top = is_last ? settings.top : bottom + settings.thickness;
    std::optional<LitCells> upper = cells_at(engine, top, settings);
    RiseSlab slab{top, Millimeters{std::numeric_limits<double>::infinity()}};
    if (lower && upper)
      slab.distance = distance.add_slab(cells_within(engine, settings, {bottom, top}, *lower, *upper, stop));
    else
      distance.forget();
    slabs.push_back(slab);
    stop.spend(static_cast<std::size_t>(settings.display.width.count()) *
               static_cast<std::size_t>(settings.display.height.count()));
    bottom = top;
    lower = std::move(upper);
  }
  return slabs;
}

}  // namespace contourd
