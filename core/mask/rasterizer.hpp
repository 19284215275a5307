// Fills polygons into a mask with exact area coverage (grey) or by pixel centres.
//
// Every side adds its changes in the winding number to the pixels that it passes (see CoverageBand). The sums
// are whole numbers and two sides' ends are rounded alike where they meet, so closed polygons cancel exactly
// at the end of each row: no residue can spill, and every machine computes the same bytes. The display is
// painted in bands of rows; only rows and blocks that hold something, or held something before, are written.
//
// A pixel's mean winding number is its coverage only if the winding numbers are 0 or 1. If a pixel shows
// others (polygons overlap, or one is wound the wrong way), the mask is painted again: pixels that several
// outlines share are filled by the sides themselves (SharedPixels). If one of them has too many sides for
// that, all sides are cut where they meet, and sides that are no outline of the non-zero set are dropped. If
// all overlaps in a mask are thinner than a pixel, no pixel may show them: the parts add up there, to at most
// 1.
//
// Not thread-safe; allocates only while the number of sides grows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/contour/contour_loops.hpp"
#include "core/contour/slicer.hpp"
#include "core/geometry/arranged_sides.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/mask/conic_rows.hpp"
#include "core/mask/coverage_band.hpp"
#include "core/mask/mask.hpp"
#include "core/mask/pixel_map.hpp"
#include "core/mask/shared_pixels.hpp"

namespace contourd {

enum class AntiAliasing {
  On,  // grey: the covered part of the pixel
  // 255 if the pixel's centre is inside, else 0 (the thesis's way). A centre on a side is inside if the solid
  // lies right of the side, or below it for a level side.
  Off,
};

class Rasterizer {
 public:
  // Makes a rasterizer with a dark mask. Throws std::invalid_argument unless both sides are 1 to 16384
  // pixels.
  Rasterizer(Pixels width, Pixels height, AntiAliasing anti_aliasing);

  // Adds a directed side. By the time of paint() the sides must form closed polygons, in any order. They may
  // lie outside the display, at any finite distance. The area right of a side that runs towards higher y is
  // inside.
  void add_side(PixelPoint from, PixelPoint to);
  void add_segments(std::span<const Segment> segments, const PixelMap& map);
  void add_loops(const Contours& contours, const PixelMap& map);

  // Paints all polygons added since the last call, replacing the previous picture. False if the budget was
  // overrun: mask() is of no use until the next call.
  [[nodiscard]] bool paint(MaskBudget& budget);
  // Paints without a limit on time. The mask is valid until the next call. Throws std::length_error for more
  // sides than a budget holds.
  const Mask& paint();
  // Fully lights the pixels of the last picture whose centres lie in one of these convex loops: a separate
  // plane, in which nothing is grey. The loops may overlap, and lie outside the display.
  void light(const Contours& convex, const PixelMap& map);
  void light(std::span<const ConicCut> cuts, const PixelMap& map);
  // Makes such pixels dark.
  void darken(const Contours& convex, const PixelMap& map);
  // Removes all polygons added since the last paint().
  void clear();
  // Returns the last mask painted; dark before that.
  [[nodiscard]] const Mask& mask() const { return mask_; }

 private:
  // The rest of a side that is still to be added, from the top down.
  struct CoveredSide {
    double x;               // column at y
    double slope;           // columns for each unit of height; sign reversed if the side runs upwards
    double half_steepness;  // units of height for each column, halved; negative if the side runs upwards
    std::int32_t y, end_y;  // rows, in units of 1 / CoverageBand::kOne
    std::int32_t sign;      // +1 if the side runs downwards
    std::uint32_t next;     // next side in the band's list
    std::int32_t top_y;     // upper end of the whole side
  };
  // A level side: changes no row's winding numbers, but bounds the inside of other polygons.
  struct LevelSide {
    std::int32_t y;  // in units of 1 / CoverageBand::kOne
    double from_x, to_x;
  };
  // The content of the mask.
  struct Content {
    std::vector<std::uint64_t> dark, full;  // see RowBlocks
    std::vector<std::uint8_t> band_lit;     // by band: there is some light
  };
  struct CenterSide {
    PixelPoint from, to;        // running downwards
    double slope;               // columns for each row
    std::int32_t row, end_row;  // rows whose centre lines the side crosses
    std::int32_t sign;
    std::uint32_t next;
  };

  // Overlaps end the painting, are filled pixel by pixel, or are gone, since all sides have been united.
  enum class Overlaps { Searched, Filled, Gone };
  // A mask or a band was painted whole, to an overlap that cannot be painted this way, or until the budget
  // was overrun.
  enum class Painted { All, ToAnOverlap, Overrun };

  void add_covered(PixelPoint from, PixelPoint to);
  void add_cut(PixelPoint from, PixelPoint to);
  void add_covered_within(PixelPoint from, PixelPoint to);
  void add_centers(PixelPoint from, PixelPoint to);
  [[nodiscard]] static double first_column(const CenterSide& side);
  [[nodiscard]] Painted paint_bands(MaskBudget& budget, Overlaps overlaps);
  [[nodiscard]] Painted paint_band(MaskBudget& budget, std::int32_t first_row, Overlaps overlaps);
  void work_off_and_count(std::int32_t first_row, std::int32_t end_row);
  [[nodiscard]] Painted fill_shared_pixels(MaskBudget& budget, std::int32_t first_row);
  void begin_again();
  [[nodiscard]] bool unite_sides(MaskBudget& budget);
  [[nodiscard]] RowBlocks blocks_of(std::int32_t row);
  template <typename See>
  void work_off_covered_sides(std::int32_t first_row, std::int32_t end_row, See&& see);
  [[nodiscard]] UnitSide unit_side(std::uint32_t number) const;
  void work_off_center_sides(std::int32_t first_row, std::int32_t end_row);
  [[nodiscard]] std::uint32_t& first_side_at(std::int32_t row) {
    return first_side_[static_cast<std::size_t>(row >> band_bits_)];
  }

  Mask mask_;
  std::int32_t width_, height_;
  AntiAliasing anti_aliasing_;
  CoverageBand band_;
  int band_bits_;                           // 2^band_bits_ rows a band
  std::vector<CoveredSide> covered_sides_;  // with anti-aliasing
  std::vector<LevelSide> level_sides_;      // with anti-aliasing
  std::vector<CenterSide> center_sides_;    // without anti-aliasing
  std::vector<std::uint32_t> first_side_;   // by band: number of the first side in its list
  Content content_;                         // of mask_
  SharedPixels shared_;                     // pixels of a band in which polygons may overlap
  std::size_t next_level_ = 0;              // the first level side that no band has counted
  ArrangedSides arranged_;                  // sides of polygons with too many sides in a pixel
  ConicRows lit_rows_;
};

}  // namespace contourd
