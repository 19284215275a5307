// The room around every point above the plate: a coarse grid of distances to the models, never too great,
// answers most questions at once; where it cannot, the sweep's layers are checked. The build area's edges
// also count as obstacles. Immutable once built; thread-safe. Deterministic.
//
// Memory: one byte a cell, at most kMostCells cells; a large region has larger cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/clearance/lit_layers.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/support/plate_segment.hpp"

namespace contourd {

class ClearanceField {
 public:
  static constexpr std::size_t kMostCells = std::size_t{1} << 24;
  // Distances are whole multiples of kUnit_mm, rounded down, and at most kGreatest_mm.
  static constexpr double kUnit_mm = 0.02;
  static constexpr double kGreatest_mm = 3;
  // Distance between two samples along a segment. Where both are clear by R, the segment between them is
  // clear by at least R - kLook_mm^2 / (8 R): 10 um less at R = 0.5 mm.
  static constexpr double kLook_mm = 0.2;
  // Length of the first part of a tip or a foot on a model, which the surface at its end may touch.
  static constexpr double kAtSurface_mm = 0.4;

  struct Region {
    double left = 0, right = 0, front = 0, back = 0, top = 0;  // millimetres from the plate's centre
  };
  struct Settings {
    DisplayGeometry build_area;
    double clearance_mm = 0;  // to the models; none to the build area's edges
  };

  // Every queried point must lie in the region and at least kGreatest_mm below its top, because nothing
  // counts as clear outside the region. `layers` must outlive the field. The field is unusable if `stop` was
  // requested.
  ClearanceField(const LitLayers& layers, const Region& region, const Settings& settings,
                 const std::stop_token& stop);

  // True if a ball at that place keeps the clearance.
  [[nodiscard]] bool has_room(const PlatePoint& center, double radius_mm) const;
  // True if a ball keeps the clearance everywhere on the segment.
  [[nodiscard]] bool has_room(const PlateSegment& segment, double radius_mm) const;
  // True if a ball at that place does not touch the models: for tips, which have no clearance.
  [[nodiscard]] bool is_free(const PlatePoint& center, double radius_mm) const {
    return layers_.is_clear(center, radius_mm);
  }

  // True if a ball at that place lies in the build area.
  [[nodiscard]] bool is_inside(const PlatePoint& center, double radius_mm) const {
    return edge_distance(center) >= radius_mm;
  }

  // Returns the nearest place at which a ball of that radius lies in the build area.
  [[nodiscard]] PlatePoint moved_inside(const PlatePoint& center, double radius_mm) const;

  // The grid's dimensions. Cells of a level are stored row by row from the back to the front, levels from the
  // plate up.
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::int32_t levels() const { return levels_; }
  [[nodiscard]] double cell_mm() const { return cell_mm_; }
  [[nodiscard]] double level_mm() const { return level_mm_; }
  // Returns the distances at the middles of a level's cells, less the clearance, in units. REQUIRES: 0 <=
  // level < levels().
  [[nodiscard]] std::span<const std::uint8_t> level(std::int32_t level) const;
  [[nodiscard]] PlatePoint middle_of(std::int32_t column, std::int32_t row, std::int32_t level) const;
  struct Cell {
    std::int32_t column, row, level;
  };
  // Returns the cell of a point, which may lie outside the grid.
  [[nodiscard]] Cell cell_of(const PlatePoint& point) const;
  [[nodiscard]] const LitLayers& layers() const { return layers_; }

 private:
  // Bounds for the room that a ball has to spare, from the grid alone; negative if it does not fit.
  struct Slack {
    double least_mm, greatest_mm;
  };

  // Squared distances in squared units, by cell.
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

  const LitLayers& layers_;
  double clearance_mm_;
  double beyond_mm_ = 0;  // the clearance plus the solid that may extend beyond a lit pixel's middle
  Point half_area_mm_;    // half the width and depth of the build area
  std::int32_t pixels_ = 1, steps_ = 1;  // pixels along a cell's side, layers in its height
  std::int32_t first_pixel_ = 0, first_pixel_row_ = 0;
  std::int32_t columns_ = 0, rows_ = 0, levels_ = 0;
  double cell_mm_ = 1, level_mm_ = 1;
  std::vector<std::uint8_t> distances_;
  std::vector<std::uint8_t> edges_;  // by cell of a level: distance to the build area's edges
};

}  // namespace contourd
