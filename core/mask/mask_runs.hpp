// The lit pixels of a mask as horizontal runs, row by row, from which islands and areas are found. Keeps its
// memory between calls: allocates only while masks grow. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// The lit pixels [first, end) of one row, with dark pixels or the display's edge on both sides.
struct PixelRun {
  std::int32_t row, first, end;
  std::uint32_t grey;  // sum of its grey values; at most 16384 * 255
};

class MaskRuns {
 public:
  // Replaces the contents by the runs of this mask.
  void extract(const Mask& mask);
  // Replaces the contents by the runs of pixels that have at least this grey value. REQUIRES: `lit` holds
  // this mask's lit pixels.
  void extract_bright(const Mask& mask, const MaskRuns& lit, std::uint8_t least_grey);

  // Returns the runs from the top row down, each row from left to right.
  [[nodiscard]] std::span<const PixelRun> runs() const { return runs_; }
  // Returns the runs of one row, after an extract(). REQUIRES: 0 <= row < height of the mask.
  [[nodiscard]] std::span<const PixelRun> in_row(std::int32_t row) const {
    expects(0 <= row && row < rows(), "the row is in the mask");
    const auto i = static_cast<std::size_t>(row);
    return std::span(runs_).subspan(row_starts_[i], row_starts_[i + 1] - row_starts_[i]);
  }
  // Returns the index in runs() of a row's first run.
  [[nodiscard]] std::uint32_t first_in_row(std::int32_t row) const {
    return row_starts_[static_cast<std::size_t>(row)];
  }
  [[nodiscard]] std::int32_t rows() const { return static_cast<std::int32_t>(row_starts_.size()) - 1; }
  // Returns the sum of all grey values: 255 times the exposed area in pixels.
  [[nodiscard]] std::uint64_t grey_sum() const { return grey_sum_; }

 private:
  void extract_row(std::int32_t row, std::span<const std::uint8_t> pixels);
  void extract_bright_from(const PixelRun& run, std::span<const std::uint8_t> pixels,
                           std::uint8_t least_grey);

  std::vector<PixelRun> runs_;
  std::vector<std::uint32_t> row_starts_;
  std::uint64_t grey_sum_ = 0;
};

// Calls meet(i, j) for every run i of `a` and j of `b` that share a column, or come within `reach` columns of
// each other. Both are sorted from left to right, so one pass is enough.
template <typename Meet>
void for_each_meeting(std::span<const PixelRun> a, std::span<const PixelRun> b, std::int32_t reach,
                      Meet&& meet) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (a[i].first < b[j].end + reach && b[j].first < a[i].end + reach) meet(i, j);
    // The run that ends first meets nothing further right.
    if (a[i].end < b[j].end) {
      ++i;
    } else {
      ++j;
    }
  }
}

}  // namespace contourd
