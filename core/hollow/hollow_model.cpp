#include "core/hollow/hollow_model.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/hollow/cavity.hpp"
#include "core/hollow/cavity_bodies.hpp"
#include "core/hollow/cavity_drains.hpp"
#include "core/hollow/cavity_grid.hpp"
#include "core/hollow/infill_struts.hpp"
#include "core/hollow/solid_columns.hpp"
#include "core/hollow/wall_distance.hpp"
#include "core/support/support_structure.hpp"

namespace contourd {
namespace {

// Walls have at least two cells.
constexpr double kLeastWallCells = 2;
// A narrower hole may lie between the pixels' centres, and stay closed.
constexpr double kNarrowestHolePixels = 2;

// One search, with cells of one size.
class CavitySearch {
 public:
  CavitySearch(const HollowRequest& request, const CavityGrid& grid)
      : request_(request), grid_(grid), bodies_(static_cast<std::uint64_t>(kLeastCavityMm3 / cell_mm3())) {}

  enum class Outcome { Found, Stopped, TooIntricate };

  Outcome run(const std::stop_token& stop) {
    const auto failure = solid_.sample(request_.model.model, grid_, kMostCavityEnds, stop);
    if (failure == SolidColumns::Failure::Stopped) return Outcome::Stopped;
    if (failure == SolidColumns::Failure::TooIntricate) return Outcome::TooIntricate;
    WallDistance wall(solid_, grid_, request_.settings.wall);
    std::optional<InfillStruts> struts;
    if (request_.settings.infill) struts.emplace(*request_.settings.infill, grid_);
    for (std::int32_t slice = 0; slice < grid_.slices; ++slice) {
      if (stop.stop_requested()) return Outcome::Stopped;
      slice_runs_.clear();
      if (struts) struts->begin(slice);
      find_runs(wall.next(), struts);
      bodies_.add_slice(slice_runs_);
      if (bodies_.runs().size() > kMostCavityEnds) return Outcome::TooIntricate;
    }
    bodies_.finish();
    return Outcome::Found;
  }

  // Returns nullopt if `stop` is requested.
  std::optional<HollowedModel> result(const std::stop_token& stop) {
    HollowedModel hollowed;
    hollowed.cell = Millimeters{grid_.cell_mm};
    hollowed.cavities = bodies_.bodies();
    for (const CavityRun& run : bodies_.runs())
      hollowed.volume_mm3 += (run.end - run.first) * cell_mm3();
    if (!open_cavities(hollowed, stop)) return std::nullopt;
    hollowed.least_carrying = least_carrying();
    hollowed.memory = bodies_.runs().size_bytes() + bodies_.starts().size_bytes();
    std::vector<SupportPrimitive> holes(request_.holes.begin(), request_.holes.end());
    holes.insert(holes.end(), hollowed.holes.begin(), hollowed.holes.end());
    std::shared_ptr<const SectionSource> drilled;
    if (!holes.empty()) drilled = std::make_shared<const SupportStructure>(std::move(holes));
    hollowed.removed = hollowed.cavities == 0
                           ? drilled
                           : std::make_shared<const Cavity>(
                                 grid_, std::vector(bodies_.starts().begin(), bodies_.starts().end()),
                                 std::vector(bodies_.runs().begin(), bodies_.runs().end()), drilled);
    return hollowed;
  }

 private:
  [[nodiscard]] double cell_mm3() const { return grid_.cell_mm * grid_.cell_mm * grid_.cell_mm; }

  // Finds the runs of cells that are not within the wall, nor in a strut.
  void find_runs(std::span<const std::uint8_t> within, const std::optional<InfillStruts>& struts) {
    for (std::int32_t row = 0; row < grid_.rows && !within.empty(); ++row) {
      const auto cells =
          within.subspan(static_cast<std::size_t>(row) * static_cast<std::size_t>(grid_.columns),
                         static_cast<std::size_t>(grid_.columns));
      const auto is_cavity = [&](std::int32_t column) {
        return cells[static_cast<std::size_t>(column)] == 0 && !(struts && struts->fills(column, row));
      };
      for (std::int32_t column = 0; column < grid_.columns; ++column) {
        if (!is_cavity(column)) continue;
        const std::int32_t first = column;
        while (column < grid_.columns && is_cavity(column))
          ++column;
        slice_runs_.push_back({static_cast<std::uint16_t>(row), static_cast<std::uint16_t>(first),
                               static_cast<std::uint16_t>(column)});
      }
    }
  }

  // Finds the holes; false if `stop` is requested.
  bool open_cavities(HollowedModel& hollowed, const std::stop_token& stop) const {
    const bool stands = request_.model.elevation.above_plate() == Nanometers{};
    std::vector<bool> open;  // by body
    for (std::uint32_t body = 0; body < bodies_.bodies(); ++body) {
      if (stop.stop_requested()) return false;
      open.push_back(is_opened(bodies_, body, grid_, request_.holes));
    }
    std::vector<CavityBasin> closed;
    if (request_.settings.hole > Millimeters{})
      std::ranges::copy_if(bodies_.basins(), std::back_inserter(closed),
                           [&](const CavityBasin& basin) { return !open[basin.body]; });
    const auto drains = find_drains(solid_, bodies_, closed, grid_, request_.settings.hole, stands, stop);
    if (!drains) return false;
    for (const BasinDrain& drain : *drains) {
      hollowed.holes.push_back(drain.hole);
      open[drain.body] = true;
    }
    hollowed.closed = static_cast<std::size_t>(std::ranges::count(open, false));
    return true;
  }

  [[nodiscard]] double least_carrying() const {
    double least = std::numeric_limits<double>::infinity(), largest = 0;
    for (std::int32_t slice = grid_.slices - 1; slice >= 0; --slice) {
      double cavity = 0;
      for (const CavityRun& run : bodies_.in_slice(slice))
        cavity += run.end - run.first;
      const double solid = solid_.solid_cells()[static_cast<std::size_t>(slice)] - cavity;
      if (cavity > 0 && largest > 0) least = std::min(least, solid / largest);
      largest = std::max(largest, solid);
    }
    return least;
  }

  const HollowRequest& request_;
  CavityGrid grid_;
  SolidColumns solid_;
  std::vector<CavityRun> slice_runs_;
  CavityBodies bodies_;
};

}  // namespace

std::uint64_t memory_to_hollow(const Bounds& model, Millimeters finest) {
  const CavityGrid grid = CavityGrid::around(model, finest, finest, kMostCavityCells);
  // Bytes for each cell of a slice in SolidColumns (two masks, two numbers) and WallDistance; for each end in
  // SolidColumns, and for each run in CavityBodies, twice over while it removes the small ones.
  constexpr std::uint64_t kForCell = 10 + 8, kForEnd = 10, kForRun = 2 * 10 + 20;
  return grid.cells_in_slice() * kForCell + kMostCavityEnds * (kForEnd + kForRun);
}

std::optional<HollowedModel> hollow_model(const HollowRequest& request, const std::stop_token& stop) {
  const double wall = request.settings.wall.count();
  expects(wall > 0 && request.finest.count() > 0 && request.settings.hole.count() >= 0,
          "the lengths are positive");
  expects(!request.settings.infill || (request.settings.infill->strut.count() > 0 &&
                                       request.settings.infill->strut < request.settings.infill->cell),
          "the struts are thinner than their cells");
  if (request.settings.hole > Millimeters{} && request.settings.hole < request.finest * kNarrowestHolePixels)
    throw std::range_error(
        "its holes (hole_mm) would be narrower than two pixels of the display, and could stay closed");
  const Millimeters least = request.settings.wall / WallDistance::kThickestCells;
  for (double cells = kMostCavityCells;; cells /= 8) {
    const CavityGrid grid = CavityGrid::around(request.model.model->bounds(), request.finest, least, cells);
    if (wall < kLeastWallCells * grid.cell_mm)
      throw std::range_error("the walls would be thinner than two of the cells that the cavity is made of");
    CavitySearch search(request, grid);
    switch (search.run(stop)) {
      case CavitySearch::Outcome::Found:
        return search.result(stop);
      case CavitySearch::Outcome::Stopped:
        return std::nullopt;
      case CavitySearch::Outcome::TooIntricate:
        break;
    }
  }
}

}  // namespace contourd
