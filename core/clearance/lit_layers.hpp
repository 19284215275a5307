// All layers of a sweep as runs of lit pixels: the models on the plate, for distance queries.
//
// A lit pixel stands for everything that may be solid around its middle: a pixel to each side, and a layer up
// and down, since a pixel is lit from half its area on and a layer is cut at its middle. Not thread-safe
// while layers are added; thread-safe afterwards. Memory: 4 bytes per run and per row.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/overhangs/overhang_sweep.hpp"

namespace contourd {

class LitLayers final : public LayerObserver {
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
  // Returns the row's runs from left to right; empty if the row or the layer is beyond all lit pixels.
  [[nodiscard]] std::span<const Run> runs_in(std::int32_t layer, std::int32_t row) const;

  // Returns the number of runs in all layers.
  [[nodiscard]] std::uint32_t runs() const { return static_cast<std::uint32_t>(runs_.size()); }
  // Returns the number of one of runs_in(), which counts all runs from the lowest layer's first row on.
  [[nodiscard]] std::uint32_t number_of(const Run& run) const {
    return static_cast<std::uint32_t>(&run - runs_.data());
  }
  // Returns the number of the run to the left of the dark pixel that contains the point; nullopt if the pixel
  // is lit, or the row has no run on one of its sides.
  [[nodiscard]] std::optional<std::uint32_t> gap_at(const PlatePoint& point) const;

  // True if the pixel that contains the point is lit in the layer that contains it.
  [[nodiscard]] bool is_lit(const PlatePoint& point) const;
  // Returns the number of lit pixels within a distance of the point in its layer, counted up to `most`.
  [[nodiscard]] int lit_around(const PlatePoint& point, double distance_mm, int most) const;
  // True if no part of the models can be nearer to the point than the distance.
  [[nodiscard]] bool is_clear(const PlatePoint& point, double distance_mm) const;
  // Returns the height of the first solid straight below; nullopt if there is none within `down_mm`.
  [[nodiscard]] std::optional<double> top_below(const PlatePoint& point, double down_mm) const;
  // Returns the height of the first solid that begins straight above; nullopt if there is none within
  // `up_mm`.
  [[nodiscard]] std::optional<double> underside_above(const PlatePoint& point, double up_mm) const;

 private:
  struct Layer {
    std::int32_t first_row, end_row;
    std::size_t first_start;  // index in row_starts_
  };

  // Layer, row and column count from 0 and may be out of range.
  [[nodiscard]] bool is_pixel_lit(double layer, double row, double column) const;
  [[nodiscard]] double column_of(double x_mm) const { return std::floor(x_mm / pitch_mm_ + columns_ / 2.0); }
  [[nodiscard]] double row_of(double y_mm) const { return std::floor(rows_ / 2.0 - y_mm / pitch_mm_); }
  [[nodiscard]] bool is_disc_clear(std::int32_t layer, double row, double column, double disc) const;

  std::int32_t columns_ = 0, rows_ = 0;
  double pitch_mm_ = 1, step_mm_ = 1;
  std::int32_t stride_ = 1;  // from one examined layer to the next
  std::vector<Layer> layers_;
  std::vector<std::uint32_t> row_starts_;  // start of each of a layer's rows, and the end of its last one
  std::vector<Run> runs_;
};

}  // namespace contourd
