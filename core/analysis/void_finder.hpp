// Voids: dark regions of the layers that what is printed so far closes towards the plate and all around. A
// part hangs from the plate and grows downwards, so a void has one way out, into the film: it sucks there
// when the plate is lifted, until it opens or is closed for good.
//
// Dark pixels that share a side, in a layer or from one layer to the next, are one void; resin finds no way
// through a corner. What comes to the display's edge is outside. Takes a layer at a time and keeps no more
// than one: memory in proportion to a layer's runs, time too. Allocates only while layers grow. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// In the layers as they were when they were the last ones: what becomes one void later was as many before.
struct MaskVoid {
  std::int32_t first_layer = 0, last_layer = 0;
  std::int32_t widest_layer = 0;   // where it had the largest area that it sucks with; the first of them
  std::int64_t widest_pixels = 0;  // of that area
  PixelPoint center{};             // mean of those pixels' centres
  std::int64_t volume = 0;         // pixels times nanometers of thickness, of all its layers
  bool on_plate = false;           // begins on the first layer: the plate closes it there
  bool closed = false;  // the layer above its last one closes it; else it opens there, or the print ends
};

class VoidFinder {
 public:
  VoidFinder() = default;
  // Its rows point into its gaps.
  VoidFinder(const VoidFinder&) = delete;
  VoidFinder& operator=(const VoidFinder&) = delete;

  struct Layer {
    std::int32_t number = 0;  // greater than the one before
    Nanometers thickness{};
  };

  // The voids that end beneath this layer. Valid until the next call. REQUIRES: `solid` holds runs of a mask
  // as high as those before.
  [[nodiscard]] std::span<const MaskVoid> add_layer(const MaskRuns& solid, const Layer& layer);
  // The print ends: the voids that are still open, at the last layer. The next layer is the first of another
  // print.
  [[nodiscard]] std::span<const MaskVoid> end();

 private:
  // Dark pixels [first, end) of a row between two runs that are not.
  struct Gap {
    std::int32_t row, first, end;
    std::uint32_t void_number;  // from 1 in voids; 0: it has a way out
  };
  // A row's gaps, and what they lie between: outside is what is left of `first` and from `end` on.
  struct Row {
    std::span<Gap> gaps{};
    std::int32_t first = 0, end = 0;
  };
  // What is dark between a layer's runs, in the rows [first_row, end_row) that have any.
  struct LayerGaps {
    std::int32_t first_row = 0, end_row = 0;
    std::vector<Gap> gaps;
    std::vector<Row> rows;
    std::vector<MaskVoid> voids;  // that are closed so far

    // Without runs, and beyond the display's edge, all is outside.
    [[nodiscard]] Row row(std::int32_t number) const {
      const bool lit = number >= first_row && number < end_row;
      return lit ? rows[static_cast<std::size_t>(number - first_row)] : Row{};
    }
  };
  // This layer's area of a void.
  struct Area {
    std::int64_t pixels = 0;
    double sum_x = 0, sum_y = 0;  // of halves of whole numbers, hence exact
  };

  void find_gaps(const MaskRuns& solid);
  void join_rows();
  void join_layers();
  void note_areas();
  void note_voids(const Layer& layer);
  // The number of a layer's gap among what is joined: behind the outside and the voids beneath.
  [[nodiscard]] std::uint32_t node_of(const Gap& gap) const;
  [[nodiscard]] std::uint32_t root_of(std::uint32_t node);
  void join(std::uint32_t a, std::uint32_t b);

  LayerGaps layer_, beneath_;
  std::int32_t height_ = 0;
  std::int32_t last_layer_ = -1;
  std::vector<std::uint32_t> parents_;  // the smallest of what is joined is its root; 0 is the outside
  std::vector<std::uint32_t> void_of_;  // by root: the number of its void; 0: none yet
  std::vector<Area> areas_;             // by void
  std::vector<MaskVoid> ended_;
};

}  // namespace contourd
