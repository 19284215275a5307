// Recognises a model that brings its supports along, layer by layer from the plate up. Not thread-safe.
//
// A support is a column: it begins on the plate or on a raft, narrows to a tip, and widens beyond the tip
// into what it holds, which is much larger. A table's leg does not narrow, and the strut of a lattice ends in
// a node that is not much larger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/overhangs/layer_parts.hpp"

namespace contourd {

class OwnSupports {
 public:
  // The size of a pixel, and the thickness of a layer.
  struct Grid {
    double pixel_mm, layer_mm;
  };
  explicit OwnSupports(Grid grid) : grid_(grid) {}

  // Adds the next layer up. All layers have the same size.
  void add_layer(const MaskRuns& lit);

  // True if there are enough tips so far to hold a model: three.
  [[nodiscard]] bool found() const { return tips_ >= 3; }

 private:
  // A part of a layer, with what is beneath it, that may be a support.
  struct Column {
    bool may_be = true;
    double widest_mm2 = 0;         // its widest section before it narrows
    double narrowest_mm2 = 0;      // its narrowest section after that
    std::size_t tips = 0;          // tips on which it widens
    std::size_t tips_beneath = 0;  // tips that end in this part
    [[nodiscard]] bool is_tip() const;
  };

  void carry_up(const MaskRuns& lit);
  void widen(Column& column, double area_mm2);

  Grid grid_;
  std::size_t layer_ = 0;  // counted from the first that is not dark
  std::size_t tips_ = 0;
  LayerParts parts_;
  MaskRuns beneath_;
  std::vector<std::uint32_t> part_of_run_beneath_;
  std::vector<Column> columns_, columns_beneath_;  // by part
};

}  // namespace contourd
