// Voids: dark regions that the layers printed so far close towards the plate and on all sides. A part hangs
// from the plate and grows downwards, so a void's only opening is towards the film: it sucks there when the
// plate is lifted, until it opens elsewhere or is closed for good.
//
// Dark pixels that share a side, in a layer or from one layer to the next, are the same void; resin cannot
// pass through a corner. A dark region that reaches the display's edge is outside. Takes a layer at a time
// and keeps only one: time and memory in proportion to a layer's runs. Allocates only while layers grow. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/units.hpp"
#include "core/mask/mask_runs.hpp"
#include "core/mask/pixel_map.hpp"

namespace contourd {

// A void, measured in each layer when it was the newest: voids that merge later count separately before.
struct MaskVoid {
  std::int32_t first_layer = 0, last_layer = 0;
  std::int32_t widest_layer = 0;   // the first layer in which the open area was largest
  std::int64_t widest_pixels = 0;  // pixels of that area
  PixelPoint center{};             // mean of that area's pixel centres
  std::int64_t volume = 0;         // sum over the layers: pixels times thickness in nanometers
  bool on_plate = false;           // true if the void begins on the first layer, where the plate closes it
  bool closed = false;  // true if the layer above the last one closes the void; else the void opens there, or
                        // the print ends
};

class VoidFinder {
 public:
  VoidFinder() = default;
  // Not copyable: the rows point into the gaps.
  VoidFinder(const VoidFinder&) = delete;
  VoidFinder& operator=(const VoidFinder&) = delete;

  struct Layer {
    std::int32_t number = 0;  // greater than the previous layer's
    Nanometers thickness{};
  };

  // Adds a layer and returns the voids that end beneath it. Valid until the next call. REQUIRES: `solid`
  // holds runs of a mask as high as the previous ones.
  [[nodiscard]] std::span<const MaskVoid> add_layer(const MaskRuns& solid, const Layer& layer);
  // Ends the print and returns the voids that are still open at the last layer. The next layer is the first
  // of another print.
  [[nodiscard]] std::span<const MaskVoid> end();

 private:
  // Dark pixels [first, end) of a row between two solid runs.
  struct Gap {
    std::int32_t row, first, end;
    std::uint32_t void_number;  // index in voids + 1; 0: outside
  };
  // The gaps of a row and the range that contains them: pixels left of `first` and from `end` on are outside.
  struct Row {
    std::span<Gap> gaps{};
    std::int32_t first = 0, end = 0;
  };
  // The dark gaps between a layer's runs, in the rows [first_row, end_row) that have runs.
  struct LayerGaps {
    std::int32_t first_row = 0, end_row = 0;
    std::vector<Gap> gaps;
    std::vector<Row> rows;
    std::vector<MaskVoid> voids;  // voids that are closed so far

    // Returns the row; an empty one, all outside, if it has no runs or lies beyond the display's edge.
    [[nodiscard]] Row row(std::int32_t number) const {
      const bool lit = number >= first_row && number < end_row;
      return lit ? rows[static_cast<std::size_t>(number - first_row)] : Row{};
    }
  };
  // The area of a void in this layer.
  struct Area {
    std::int64_t pixels = 0;
    double sum_x = 0, sum_y = 0;  // exact: sums of halves of whole numbers
  };

  void find_gaps(const MaskRuns& solid);
  void join_rows();
  void join_layers();
  void note_areas();
  void note_voids(const Layer& layer);
  // Returns the union-find node of a gap; the outside and the voids beneath come first.
  [[nodiscard]] std::uint32_t node_of(const Gap& gap) const;
  [[nodiscard]] std::uint32_t root_of(std::uint32_t node);
  void join(std::uint32_t a, std::uint32_t b);

  LayerGaps layer_, beneath_;
  std::int32_t height_ = 0;
  std::int32_t last_layer_ = -1;
  std::vector<std::uint32_t> parents_;  // union-find: the smallest joined node is the root; 0 is the outside
  std::vector<std::uint32_t> void_of_;  // by root: number of the void; 0: none yet
  std::vector<Area> areas_;             // by void
  std::vector<MaskVoid> ended_;
};

}  // namespace contourd
