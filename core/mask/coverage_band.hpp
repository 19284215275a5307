// The rows that the rasterizer works on at a time: what its sides change in the winding number along each
// row, and the painting of it. Small enough to stay in the cache, whatever the display's size.
//
// A pixel's cell has the difference between its winding number, averaged over the pixel, and that of the
// pixel left of it. One sum along the row gives every pixel's winding. One byte a block of 16 pixels tells
// whether any of its cells is in use, so that painting visits only what a side has touched. Not thread-safe;
// allocates in its constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/mask/block_painter.hpp"

namespace contourd {

// What the blocks of one mask row hold at present, a bit a block, 64 blocks a word: all 0, or all 255.
struct RowBlocks {
  std::span<std::uint64_t> dark, full;
};

class CoverageBand {
 public:
  // The winding number one in the units of the cells: up to 65,535 polygons may overlap in a pixel.
  static constexpr int kOneBits = kWindingBits;
  static constexpr std::int32_t kOne = 1 << kOneBits;
  static constexpr std::size_t kBlock = kBlockPixels;

  explicit CoverageBand(std::int32_t width);

  // How many rows it holds: a power of two.
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  // Words in each span of RowBlocks.
  [[nodiscard]] std::size_t chunks() const { return chunks_; }

  // A row's cells, to be added to. Valid as long as the band. Unsigned: they wrap instead of overflowing when
  // more polygons overlap than they can hold.
  class Row {
   public:
    // From this column on the winding number is that much higher. REQUIRES: 0 <= column < width + 3.
    void add(std::size_t column, std::int32_t change) const {
      expects_costly([&] { return column < cell_count_; }, "the column is one of the row's");
      cells_[column] += static_cast<std::uint32_t>(change);
      used_[column / kBlock] = 1;
    }
    // The same for a column and the two right of it. REQUIRES: 0 <= column <= width.
    void add(std::size_t column, std::int32_t first, std::int32_t second, std::int32_t third) const {
      expects_costly([&] { return column + 2 < cell_count_; }, "the columns are some of the row's");
      cells_[column] += static_cast<std::uint32_t>(first);
      cells_[column + 1] += static_cast<std::uint32_t>(second);
      cells_[column + 2] += static_cast<std::uint32_t>(third);
      used_[column / kBlock] = 1;
      used_[(column + 2) / kBlock] = 1;
    }

   private:
    friend class CoverageBand;
    Row(CoverageBand& band, std::size_t row)
        : cells_(band.cells_.data() + row * band.stride_),
          used_(band.used_.data() + row * band.used_stride()),
          cell_count_(band.stride_) {}

    std::uint32_t* cells_;
    std::uint8_t* used_;
    std::size_t cell_count_;
  };
  // REQUIRES: 0 <= row < rows().
  [[nodiscard]] Row row(std::int32_t row) {
    expects(0 <= row && row < rows_, "the row is one of the band's");
    return {*this, static_cast<std::size_t>(row)};
  }

  // Paints what was added to a row by the non-zero rule, and forgets it. `pixels` is the whole mask row,
  // which already is as `blocks` says; only blocks that change are written.
  void paint(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks);
  // The same for contours that do not overlap. False when a pixel's winding number is not 0 to 1: they do
  // overlap, and what is painted is of no use.
  [[nodiscard]] bool paint_covered(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks);

 private:
  template <typename PaintBlock>
  void paint_row(std::size_t row, std::span<std::uint8_t> pixels, RowBlocks blocks, std::uint32_t winding,
                 PaintBlock&& paint_block_of);
  [[nodiscard]] std::size_t used_stride() const { return chunks_ * 64; }
  [[nodiscard]] std::uint64_t take_used(std::size_t row, std::size_t chunk);

  // Cells a row: the display's columns, and three more for what lies on its right edge, up to whole blocks.
  std::size_t stride_;
  std::size_t blocks_;  // a row
  std::size_t chunks_;  // 64 blocks each, a row
  std::int32_t rows_;
  std::vector<std::uint32_t> cells_;
  std::vector<std::uint8_t> used_;  // a byte a block, 0 or 1, whole chunks a row
};

}  // namespace contourd
