// How much room there is around every point above the plate: a coarse grid of distances to the models, never
// too great, that answers most questions at once; where it cannot tell, the sweep's layers do. The build
// area's edges count, too. Immutable once built; thread-safe. Deterministic.
//
// Memory: a byte a cell, of which there are at most kMostCells: in a large region cells are larger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/clearance/layer_stack.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/plate_segment.hpp"

namespace contourd {

class ClearanceField {
 public:
  static constexpr std::size_t kMostCells = std::size_t{1} << 24;
  // Distances are whole multiples of this, rounded down; none is more than the greatest.
  static constexpr double kUnit_mm = 0.02;
  static constexpr double kGreatest_mm = 3;

  struct Region {
    double left = 0, right = 0, front = 0, back = 0, top = 0;  // millimetres from the plate's centre
  };
  struct Settings {
    DisplayGeometry build_area;
    double clearance_mm = 0;  // to the models; to the edges there is none
  };

  // Everything that is asked for must lie in the region, kGreatest_mm below its top: beside it nothing is
  // clear. `layers` must outlive
  // the field. Once `stop` was asked for it is of no use.
  ClearanceField(const LayerStack& layers, const Region& region, const Settings& settings,
                 const std::stop_token& stop);

  // Whether a ball there keeps the clearance.
  [[nodiscard]] bool has_room(const PlatePoint& center, double radius_mm) const;
  // Whether it does all the way.
  [[nodiscard]] bool has_room(const PlateSegment& segment, double radius_mm) const;
  // Whether a ball there does not touch the models: for tips, which have no clearance.
  [[nodiscard]] bool is_free(const PlatePoint& center, double radius_mm) const {
    return layers_.is_clear(center, radius_mm);
  }

  // Whether it lies in the build area.
  [[nodiscard]] bool is_inside(const PlatePoint& center, double radius_mm) const {
    return edge_distance(center) >= radius_mm;
  }

  // The nearest place where it does.
  [[nodiscard]] PlatePoint moved_inside(const PlatePoint& center, double radius_mm) const;

  // The grid. Cells of a level lie row by row, levels from the plate up; rows from the back to the front.
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::int32_t levels() const { return levels_; }
  [[nodiscard]] double cell_mm() const { return cell_mm_; }
  [[nodiscard]] double level_mm() const { return level_mm_; }
  // Distances at the cells' middles, less the clearance, in units. REQUIRES: 0 <= level < levels().
  [[nodiscard]] std::span<const std::uint8_t> level(std::int32_t level) const;
  [[nodiscard]] PlatePoint middle_of(std::int32_t column, std::int32_t row, std::int32_t level) const;
  struct Cell {
    std::int32_t column, row, level;
  };
  // The cell of a point; it may lie outside the grid.
  [[nodiscard]] Cell cell_of(const PlatePoint& point) const;
  [[nodiscard]] const LayerStack& layers() const { return layers_; }

 private:
  // How a ball fits: by the grid alone.
  struct Slack {
    double least_mm, greatest_mm;
  };

  // Squares of distances in units, by cell.
  using Squares = std::vector<std::uint16_t>;

  void choose_cells(const Region& region);
  [[nodiscard]] Squares squares_in(std::int32_t level) const;
  void mark_solids(std::int32_t level, Squares& squares) const;
  void spread_in_rows(Squares& squares) const;
  [[nodiscard]] Squares spread_across_rows(const Squares& squares) const;
  void measure(std::int32_t level, std::span<const Squares* const> near, std::int32_t first_near);
  void keep_to_region(std::int32_t level);
  [[nodiscard]] std::vector<std::uint8_t> edges() const;
  [[nodiscard]] double edge_distance(const PlatePoint& point) const;
  [[nodiscard]] double region_distance(const PlatePoint& point) const;
  [[nodiscard]] Slack slack_at(const PlatePoint& center, double radius_mm) const;

  const LayerStack& layers_;
  double clearance_mm_;
  double beyond_mm_ = 0;                 // the clearance, and what may be solid beside a lit pixel
  Point half_area_mm_;                   // of the build area
  std::int32_t pixels_ = 1, steps_ = 1;  // of a cell's side, of its height
  std::int32_t first_pixel_ = 0, first_pixel_row_ = 0;
  std::int32_t columns_ = 0, rows_ = 0, levels_ = 0;
  double cell_mm_ = 1, level_mm_ = 1;
  std::vector<std::uint8_t> distances_;
  std::vector<std::uint8_t> edges_;  // distances of a level's cells to the build area's edges
};

}  // namespace contourd
