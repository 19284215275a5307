// The underside of what a sweep has seen so far, pixel by pixel: at which layer it begins there, and what
// holds it. How far a pixel reaches out is its distance from what holds it, less what the material has become
// stiffer since then: as much as it has grown in height. So a wall of 45 degrees never reaches out, a gentler
// one the farther the longer it goes on, a level one at once. Keeps its memory between layers. Not
// thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

// A pixel that is new in a layer.
struct ReachingPixel {
  SweepPixel at;
  std::uint32_t part = 0;  // of the layer
  double reach_mm = 0;     // from what holds it; infinite in an island
  double bridge_mm = 0;    // from the nearest lit pixel of the layer beneath, beyond its own neighbours
};

class Underside {
 public:
  explicit Underside(const SweepGrid& grid);

  // What is there now.
  struct Layer {
    const MaskRuns& lit;
    const MaskRuns& beneath;
    const LayerParts& parts;
  };
  struct Thresholds {
    double reach_mm, bridge_mm;
  };
  // The next layer up; the first stands on the plate. Its new pixels that reach out or bridge farther than
  // the thresholds are those of reaching() then. REQUIRES: fewer than 65535 layers.
  void add_layer(const Layer& layer, const Thresholds& thresholds);
  // From the top row down, each row from left to right. Valid until the next layer.
  [[nodiscard]] std::span<const ReachingPixel> reaching() const { return reaching_; }

  // A new pixel that stands for those around it.
  struct Sample {
    SweepPixel at;
    std::uint32_t part;
    bool steep;  // as steep as 45 degrees or steeper, as far as its own pixel tells
  };
  // One for every half millimetre along rows and columns; of steep ones one for every whole one.
  [[nodiscard]] std::span<const Sample> samples() const { return samples_; }

  // A contact holds what is connected to it in the layer that was added last, as far as it is nearer than
  // what held that before. REQUIRES: the pixel is lit there.
  void hold(SweepPixel contact, double radius_mm);

  [[nodiscard]] bool is_lit(SweepPixel pixel) const { return grid_.holds(pixel) && cell(pixel).born != 0; }
  // The layer at which the material over a pixel begins; 0 where there is none.
  [[nodiscard]] std::int32_t begins_at(SweepPixel pixel) const { return cell(pixel).born; }
  // From what holds it, in the last layer; infinite where nothing does.
  [[nodiscard]] double reach_mm(SweepPixel pixel) const { return reach_of(pixel, cell(pixel), layer_); }
  // Whether it is lit, and nothing holds it nor any lit pixel beside it.
  [[nodiscard]] bool hangs_alone(SweepPixel pixel) const;
  // The pixel nearest to a lit one that a tip of that radius can hold on all its sides; where a wall is
  // thinner, in its middle.
  [[nodiscard]] SweepPixel centered(SweepPixel at, std::int32_t tip_pixels) const;

 private:
  // Where a pixel's holder is, and at which layer that begins; 0: none yet.
  struct Cell {
    std::int16_t column = 0, row = 0;
    std::uint16_t holder_layer = 0;
    std::uint16_t born = 0;  // 0: dark
  };
  static_assert(sizeof(Cell) == 8);

  [[nodiscard]] std::size_t index_of(SweepPixel pixel) const {
    return static_cast<std::size_t>(pixel.row + 1) * stride_ + static_cast<std::size_t>(pixel.column + 1);
  }
  [[nodiscard]] const Cell& cell(SweepPixel pixel) const { return cells_[index_of(pixel)]; }
  [[nodiscard]] std::int32_t lit_pixels(SweepPixel from, SweepPixel step, std::int32_t most) const;
  [[nodiscard]] double reach_of(SweepPixel pixel, const Cell& cell, std::int32_t layer) const;
  [[nodiscard]] Cell held_by(SweepPixel pixel, const Cell& cell) const;
  void add_run(const PixelRun& run, std::uint32_t part, bool floats);
  void add_pixel(SweepPixel pixel, std::uint32_t part, bool floats);
  void bridge();
  void darken(const MaskRuns& lit, const MaskRuns& beneath);
  void collect(const Thresholds& thresholds);

  struct NewPixel {
    SweepPixel at;
    std::uint32_t part;
    SweepPixel carrier;  // the nearest lit pixel of the layer beneath; column -1: none
  };

  SweepGrid grid_;
  std::size_t stride_;
  std::int32_t field_;  // pixels between samples
  std::int32_t layer_ = 0;
  std::vector<Cell> cells_;          // with a dark rim
  std::vector<std::uint32_t> mark_;  // by cell: its place in new_, or who has been here
  std::vector<NewPixel> new_;
  std::vector<std::uint32_t> queue_;
  std::vector<ReachingPixel> reaching_;
  std::vector<SweepPixel> flood_;
  std::vector<Sample> samples_;
  std::uint32_t floods_ = 0;
  bool any_uncarried_ = false;
};

}  // namespace contourd
