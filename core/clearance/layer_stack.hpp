// All layers of a sweep as runs of lit pixels: what stands on the plate, to be asked how far away it is.
//
// A lit pixel stands for all that may be solid around its middle: a pixel to each side of it and a layer up
// and down, since a pixel is lit from half its area on and a layer is cut at its middle. Not thread-safe
// while layers come; thread-safe after that. Memory: 4 bytes a run and a row.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/overhangs/overhang_sweep.hpp"

namespace contourd {

class LayerStack final : public LayerObserver {
 public:
  // Lit pixels [first, end) of a row.
  struct Run {
    std::uint16_t first, end;
  };

  void begin(const DisplayGeometry& sweep_display, Nanometers step) override;
  void layer(Nanometers height, const MaskRuns& lit) override;

  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::int32_t layers() const { return static_cast<std::int32_t>(layers_.size()); }
  [[nodiscard]] double pitch_mm() const { return pitch_mm_; }
  [[nodiscard]] double step_mm() const { return step_mm_; }
  // From left to right; none where the row or the layer is beyond all that is lit.
  [[nodiscard]] std::span<const Run> runs_in(std::int32_t layer, std::int32_t row) const;

  // Whether the pixel and the layer that the point lies in are lit.
  [[nodiscard]] bool is_lit(const PlatePoint& point) const;
  // Whether nothing of the models may be nearer to the point than the distance.
  [[nodiscard]] bool is_clear(const PlatePoint& point, double distance_mm) const;
  // The height of the first solid straight below; nothing when there is none so far down.
  [[nodiscard]] std::optional<double> top_below(const PlatePoint& point, double down_mm) const;
  // The height of the first solid straight above that begins there; nothing when there is none so far up.
  [[nodiscard]] std::optional<double> underside_above(const PlatePoint& point, double up_mm) const;

 private:
  struct Layer {
    std::int32_t first_row, end_row;
    std::size_t first_start;  // in row_starts_
  };

  // By numbers from 0, which may be beyond the display's and the layers'.
  [[nodiscard]] bool is_pixel_lit(double layer, double row, double column) const;
  [[nodiscard]] double column_of(double x_mm) const { return std::floor(x_mm / pitch_mm_ + columns_ / 2.0); }
  [[nodiscard]] double row_of(double y_mm) const { return std::floor(rows_ / 2.0 - y_mm / pitch_mm_); }
  [[nodiscard]] bool is_disc_clear(std::int32_t layer, double row, double column, double disc) const;

  std::int32_t columns_ = 0, rows_ = 0;
  double pitch_mm_ = 1, step_mm_ = 1;
  std::int32_t stride_ = 1;  // between layers that are looked at
  std::vector<Layer> layers_;
  std::vector<std::uint32_t> row_starts_;  // of each layer's rows, and the end of its last
  std::vector<Run> runs_;
};

}  // namespace contourd
