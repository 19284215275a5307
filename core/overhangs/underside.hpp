// The underside of the material that a sweep has seen so far. For each pixel it knows the layer in which the
// material there begins, and the pixel that holds it (its holder). How far a pixel reaches out is its
// distance from the holder, less the height by which the material has grown since then, because it has become
// stiffer by that. So a wall of 45 degrees never reaches out, a flatter one reaches out farther the longer it
// continues, and a level one does at once. Keeps its memory between layers. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mask/mask_runs.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/sweep_grid.hpp"

namespace contourd {

// A new pixel of a layer that reaches out or bridges too far.
struct ReachingPixel {
  SweepPixel at;
  std::uint32_t part = 0;  // the layer's part to which it belongs
  double reach_mm = 0;     // from its holder; infinite in an island
  double bridge_mm = 0;    // from the nearest lit pixel of the layer beneath, beyond its own neighbours
};

class Underside {
 public:
  explicit Underside(const SweepGrid& grid);

  // The layer to add, the one beneath it, and the layer's parts.
  struct Layer {
    const MaskRuns& lit;
    const MaskRuns& beneath;
    const LayerParts& parts;
    Nanometers height;   // at which it was cut, above the plate
    bool rests = false;  // on the plate, wherever its material begins; the first layer always does
  };
  struct Thresholds {
    double reach_mm, bridge_mm;
  };
  // Adds the next layer up. Afterwards reaching() holds the new pixels
  // that reach out or bridge farther than the thresholds. REQUIRES: fewer than 65535 layers.
  void add_layer(const Layer& layer, const Thresholds& thresholds);
  // Returns the reaching pixels from the top row down, each row from left to right. Valid until the next
  // layer.
  [[nodiscard]] std::span<const ReachingPixel> reaching() const { return reaching_; }

  // A new pixel that represents the pixels around it.
  struct Sample {
    SweepPixel at;
    std::uint32_t part;
    bool steep;  // 45 degrees or steeper, judged by this pixel alone
  };
  // Returns one sample for every half millimetre along rows and columns, or every millimetre on steep
  // surfaces.
  [[nodiscard]] std::span<const Sample> samples() const { return samples_; }

  // Makes the contact the holder of the pixels that are connected to it in the last layer within the radius,
  // wherever that shortens their reach. REQUIRES: the pixel is lit in the last layer.
  void hold(SweepPixel contact, double radius_mm);

  [[nodiscard]] bool is_lit(SweepPixel pixel) const { return grid_.holds(pixel) && cell(pixel).born != 0; }
  // Returns the layer in which the material over a pixel begins; 0 if the pixel is dark.
  [[nodiscard]] std::int32_t begins_at(SweepPixel pixel) const { return cell(pixel).born; }
  // Returns how far a pixel reaches out from its holder in the last layer; infinite if it has no holder.
  [[nodiscard]] double reach_mm(SweepPixel pixel) const { return reach_of(pixel, cell(pixel), layer_); }
  // True if the pixel is lit and neither it nor any lit neighbour has a holder.
  [[nodiscard]] bool hangs_alone(SweepPixel pixel) const;
  // Returns the pixel nearest to a lit pixel that has material on all sides for a tip of that radius; where a
  // wall is thinner than the tip, the pixel in its middle.
  [[nodiscard]] SweepPixel centered(SweepPixel at, std::int32_t tip_pixels) const;

 private:
  // A pixel's state: the place of its holder and the layer in which the holder begins; layer 0: no holder
  // yet.
  struct Cell {
    std::int16_t column = 0, row = 0;
    std::uint16_t holder_layer = 0;
    std::uint16_t born = 0;  // layer in which the material begins; 0: dark
  };
  static_assert(sizeof(Cell) == 8);

  [[nodiscard]] std::size_t index_of(SweepPixel pixel) const {
    return static_cast<std::size_t>(pixel.row + 1) * stride_ + static_cast<std::size_t>(pixel.column + 1);
  }
  [[nodiscard]] const Cell& cell(SweepPixel pixel) const { return cells_[index_of(pixel)]; }
  [[nodiscard]] std::int32_t lit_pixels(SweepPixel from, SweepPixel step, std::int32_t most) const;
  [[nodiscard]] double reach_of(SweepPixel pixel, const Cell& cell, std::int32_t layer) const;
  [[nodiscard]] Cell held_by(SweepPixel pixel, const Cell& cell) const;
  // Where the material of a run of new pixels begins.
  enum class Beginning { OnPlate, BesideMaterial, InIsland };
  void add_run(const PixelRun& run, std::uint32_t part, Beginning beginning);
  void add_pixel(SweepPixel pixel, std::uint32_t part, Beginning beginning);
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
  std::vector<double> levels_;       // by layer: its height, in steps of the grid
  std::vector<Cell> cells_;          // with a dark rim
  std::vector<std::uint32_t> mark_;  // by cell: its index in new_, or the flood that reached it last
  std::vector<NewPixel> new_;
  std::vector<std::uint32_t> queue_;
  std::vector<ReachingPixel> reaching_;
  std::vector<SweepPixel> flood_;
  std::vector<Sample> samples_;
  std::uint32_t floods_ = 0;
  bool any_uncarried_ = false;
};

}  // namespace contourd
