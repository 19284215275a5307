#include "core/hollow/cavity_drains.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>

namespace contourd {
namespace {

struct Cell {
  std::int32_t column, row;
};

// A way from a cell of a cavity to a cell outside, in the same slice or in the same column.
struct DrainWay {
  Cell inside, outside;
  double cells = std::numeric_limits<double>::infinity();  // length of the way
};

// The cells of a slice that are open to the outside along the level.
class OutsideCells {
 public:
  OutsideCells(const SolidColumns& solid, const CavityGrid& grid, std::int32_t slice)
      : columns_(grid.columns), rows_(grid.rows), outside_(grid.cells_in_slice(), kSolid) {
    for (std::size_t place = 0; place < outside_.size(); ++place) {
      const std::span<const std::uint16_t> ends = solid.ends(place);
      if (std::ranges::count_if(ends, [&](std::uint16_t end) { return end <= slice; }) % 2 == 0)
        outside_[place] = kEmpty;
    }
    // The grid's border is empty.
    reach({0, 0});
    while (!front_.empty()) {
      const Cell cell = front_.back();
      front_.pop_back();
      for (const Cell next : {Cell{cell.column - 1, cell.row}, Cell{cell.column + 1, cell.row},
                              Cell{cell.column, cell.row - 1}, Cell{cell.column, cell.row + 1}})
        reach(next);
    }
  }

  [[nodiscard]] bool holds(Cell cell) const { return is_in_grid(cell) && outside_[index(cell)] == kReached; }

  // Returns the shortest way from a cell inside, if it is not longer than a limit.
  [[nodiscard]] DrainWay way_from(Cell inside, double limit) const {
    DrainWay way;
    for (std::int32_t ring = 1;
         ring <= std::min({way.cells, limit, std::sqrt(columns_ * columns_ + rows_ * rows_)}); ++ring) {
      for (std::int32_t along = -ring; along <= ring; ++along) {
        for (const Cell away :
             {Cell{along, -ring}, Cell{along, ring}, Cell{-ring, along}, Cell{ring, along}}) {
          const Cell outside{inside.column + away.column, inside.row + away.row};
          const double length = std::sqrt(away.column * away.column + away.row * away.row);
          if (length < std::min(way.cells, limit) && holds(outside)) way = {inside, outside, length};
        }
      }
    }
    return way;
  }

 private:
  enum : std::uint8_t { kSolid, kEmpty, kReached };

  [[nodiscard]] bool is_in_grid(Cell cell) const {
    return 0 <= cell.column && cell.column < columns_ && 0 <= cell.row && cell.row < rows_;
  }
  [[nodiscard]] std::size_t index(Cell cell) const {
    return static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(cell.column);
  }
  void reach(Cell cell) {
    if (!is_in_grid(cell) || outside_[index(cell)] != kEmpty) return;
    outside_[index(cell)] = kReached;
    front_.push_back(cell);
  }

  std::int32_t columns_, rows_;
  std::vector<std::uint8_t> outside_;
  std::vector<Cell> front_;
};

// The runs of a basin in a slice near its floor.
struct BasinFloor {
  std::vector<CavityRun> runs;
  std::int32_t slice;
};

// Returns the shortest way from the floor's columns to the outside in another slice.
DrainWay level_way(const OutsideCells& outside, const BasinFloor& floor) {
  std::vector<DrainWay> ways;
  double shortest = std::numeric_limits<double>::infinity();
  const auto try_from = [&](Cell inside) {
    const DrainWay way = outside.way_from(inside, shortest + 0.5);
    shortest = std::min(shortest, way.cells);
    if (std::isfinite(way.cells)) ways.push_back(way);
  };
  for (const CavityRun& run : floor.runs) {
    try_from({run.first, run.row});
    try_from({run.end - 1, run.row});
  }
  // The middle one of ways of about the same length is not in a corner.
  std::erase_if(ways, [&](const DrainWay& way) { return way.cells >= shortest + 0.5; });
  return ways.empty() ? DrainWay{} : ways[ways.size() / 2];
}

// Returns the shortest way down through the first solid of a column; its cell outside is in the column.
DrainWay way_down(const SolidColumns& solid, const BasinFloor& floor, const CavityGrid& grid) {
  DrainWay way;
  for (const CavityRun& run : floor.runs) {
    for (std::int32_t column = run.first; column < run.end; ++column) {
      const auto place = static_cast<std::size_t>(run.row) * static_cast<std::size_t>(grid.columns) +
                         static_cast<std::size_t>(column);
      const std::span<const std::uint16_t> ends = solid.ends(place);
      const double cells = floor.slice - ends[0];
      if (ends[1] > floor.slice && cells < way.cells) way = {{column, run.row}, {column, run.row}, cells};
    }
  }
  return way;
}

Point middle_of(const CavityGrid& grid, Cell cell) {
  return {grid.left_of(cell.column) + grid.cell_mm / 2, grid.top_of(cell.row) - grid.cell_mm / 2};
}

// Finds the holes of basins, one after another.
class DrainSearch {
 public:
  DrainSearch(const SolidColumns& solid, const CavityBodies& bodies, const CavityGrid& grid, double radius,
              bool stands_on_plate)
      : solid_(solid), bodies_(bodies), grid_(grid), radius_(radius), stands_on_plate_(stands_on_plate) {}

  std::optional<Frustum> find(const CavityBasin& basin) {
    const auto slice_above_floor = [&](double mm) {
      return std::min(basin.low + static_cast<std::int32_t>(mm / grid_.cell_mm), basin.end - 1);
    };
    const std::int32_t floor_slice = slice_above_floor(radius_ / 5),
                       axis = slice_above_floor(radius_ * 4 / 5);
    const BasinFloor floor{bodies_.in_basin(basin, floor_slice), floor_slice};
    const DrainWay level = level_way(outside_in(axis), floor);
    const DrainWay down = stands_on_plate_ ? DrainWay{} : way_down(solid_, floor, grid_);
    if (down.cells <= level.cells && std::isfinite(down.cells)) {
      const Point at = middle_of(grid_, down.inside);
      const double z = grid_.bottom_of(floor_slice) + grid_.cell_mm / 2;
      return Frustum{
          {at.x, at.y, z - down.cells * grid_.cell_mm - radius_}, {at.x, at.y, z}, radius_, radius_};
    }
    if (!std::isfinite(level.cells)) return std::nullopt;
    const double z = grid_.bottom_of(axis) + grid_.cell_mm / 2;
    const Point inside = middle_of(grid_, level.inside), outside = middle_of(grid_, level.outside);
    const double length = level.cells * grid_.cell_mm;
    const Point along{(inside.x - outside.x) / length, (inside.y - outside.y) / length};
    // Half a radius further inwards, since the floor's edge may be round.
    return Frustum{{outside.x - along.x * radius_, outside.y - along.y * radius_, z},
                   {inside.x + along.x * radius_ / 2, inside.y + along.y * radius_ / 2, z},
                   radius_,
                   radius_};
  }

 private:
  // Basins come from below upwards, and those of equal parts share their slices.
  const OutsideCells& outside_in(std::int32_t slice) {
    if (!outside_ || outside_slice_ != slice) outside_ = std::make_unique<OutsideCells>(solid_, grid_, slice);
    outside_slice_ = slice;
    return *outside_;
  }

  const SolidColumns& solid_;
  const CavityBodies& bodies_;
  const CavityGrid& grid_;
  double radius_;
  bool stands_on_plate_;
  std::unique_ptr<OutsideCells> outside_;
  std::int32_t outside_slice_ = 0;
};

}  // namespace

bool is_opened(const CavityBodies& bodies, std::uint32_t body, const CavityGrid& grid,
               std::span<const Frustum> holes) {
  const auto is_in_body = [&](double x, double y, double z) {
    const double slice = grid.slice_at(Millimeters{z});
    const double column = std::floor((x - grid.left_of(0)) / grid.cell_mm);
    const double row = std::floor((grid.top_of(0) - y) / grid.cell_mm);
    if (!(slice >= 0 && slice < grid.slices)) return false;
    const auto k = static_cast<std::size_t>(slice);
    for (std::size_t i = bodies.starts()[k]; i < bodies.starts()[k + 1]; ++i) {
      const CavityRun& run = bodies.runs()[i];
      if (bodies.body_of(i) == body && run.row == row && run.first <= column && column < run.end) return true;
    }
    return false;
  };
  return std::ranges::any_of(holes, [&](const Frustum& hole) {
    const double x = hole.upper.x - hole.lower.x, y = hole.upper.y - hole.lower.y,
                 z = hole.upper.z - hole.lower.z;
    constexpr double kMostSteps = 1e5;
    const double steps = std::min(std::ceil(std::sqrt(x * x + y * y + z * z) / grid.cell_mm), kMostSteps);
    for (double step = 0; step <= steps; ++step) {
      const double part = step / steps;
      if (is_in_body(hole.lower.x + part * x, hole.lower.y + part * y, hole.lower.z + part * z)) return true;
    }
    return false;
  });
}

std::optional<std::vector<BasinDrain>> find_drains(const SolidColumns& solid, const CavityBodies& bodies,
                                                   std::span<const CavityBasin> basins,
                                                   const CavityGrid& grid, Millimeters diameter,
                                                   bool stands_on_plate, const std::stop_token& stop) {
  DrainSearch search(solid, bodies, grid, diameter.count() / 2, stands_on_plate);
  std::vector<BasinDrain> holes;
  for (const CavityBasin& basin : basins) {
    if (stop.stop_requested()) return std::nullopt;
    if (const auto hole = search.find(basin)) holes.push_back({basin.body, *hole});
  }
  return holes;
}

}  // namespace contourd
