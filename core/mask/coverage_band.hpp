// The band of rows that the rasterizer works on at a time: collects the changes of the winding number along
// each row, and paints the row. Small enough to stay in the cache, whatever the display's size.
//
// A pixel's cell holds the difference between its winding number, averaged over the pixel, and that of the
// pixel to the left. One sum along the row gives every pixel's winding number. One byte for each block of 16
// pixels marks blocks with used cells, so that painting visits only what a side has touched. Not thread-safe;
// allocates in its constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contract/expects.hpp"
#include "core/mask/block_painter.hpp"
#include "core/mask/shared_pixels.hpp"

namespace contourd {

// The present content of the blocks of one mask row, a bit for each block, 64 blocks a word: all pixels 0, or
// all 255.
struct RowBlocks {
  std::span<std::uint64_t> dark, full;
};

class CoverageBand {
 public:
  // A winding number of 1 in the cells' units: up to 65,535 polygons may overlap in a pixel.
  static constexpr int kOneBits = kWindingBits;
  static constexpr std::int32_t kOne = 1 << kOneBits;
  static constexpr std::size_t kBlock = kBlockPixels;
  // The number of blocks in a chunk: a word of RowBlocks has a bit for each.
  static constexpr std::size_t kChunkBlocks = 64;

  explicit CoverageBand(std::int32_t width);

  // Returns the number of rows in the band: a power of two.
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  // Returns the number of words in each span of RowBlocks.
  [[nodiscard]] std::size_t chunks() const { return chunks_; }

  // The cells of a row, to be added to. Valid as long as the band. They are unsigned, so that they wrap
  // instead of overflowing if more polygons overlap than a cell can count.
  class Row {
   public:
    // Raises the winding number from this column on by `change`. REQUIRES: 0 <= column < width + 3.
    void add(std::size_t column, std::int32_t change) const {
      expects_costly([&] { return column < cell_count_; }, "the column is in the row");
      cells_[column] += static_cast<std::uint32_t>(change);
      used_[column / kBlock] = 1;
    }
    // Raises the winding number from a column on, and from the next two columns on. REQUIRES: 0 <= column <=
    // width.
    void add(std::size_t column, std::int32_t first, std::int32_t second, std::int32_t third) const {
      expects_costly([&] { return column + 2 < cell_count_; }, "the columns are in the row");
      cells_[column] += static_cast<std::uint32_t>(first);
      cells_[column + 1] += static_cast<std::uint32_t>(second);
      cells_[column + 2] += static_cast<std::uint32_t>(third);
      used_[column / kBlock] = 1;
      used_[(column + 2) / kBlock] = 1;
    }
    // Has the blocks of columns `first` to `last` painted, though nothing was added to them.
    void use(std::size_t first, std::size_t last) const {
      for (std::size_t block = first / kBlock; block <= last / kBlock; ++block)
        used_[block] = 1;
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
  // Returns a row of the band. REQUIRES: 0 <= row < rows().
  [[nodiscard]] Row row(std::int32_t row) {
    expects(0 <= row && row < rows_, "the row is in the band");
    return {*this, static_cast<std::size_t>(row)};
  }

  // Paints a row from what was added to it, by the non-zero rule, and clears it. `pixels` is the whole mask
  // row, which already has the content that `blocks` says; only blocks that change are written.
  void paint(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks);
  // Paints a row of contours that do not overlap. False if a pixel's winding number is not 0 to 1: the
  // contours do overlap, and the painted row is of no use.
  [[nodiscard]] bool paint_covered(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks);
  // Paints a row like paint(), and lets `shared` look at each of its blocks first.
  void paint_shared(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks, SharedPixels& shared);

  // Returns the number of cells in a row.
  [[nodiscard]] std::size_t stride() const { return stride_; }

 private:
  template <typename PaintBlock>
  void paint_row(std::size_t row, std::span<std::uint8_t> pixels, RowBlocks blocks, std::uint32_t winding,
                 PaintBlock&& paint_block_of);
  [[nodiscard]] std::size_t used_stride() const { return chunks_ * 64; }
  [[nodiscard]] std::uint64_t take_used(std::size_t row, std::size_t chunk);

  // Cells a row: the display's columns, and three more for sides on its right edge, up to whole blocks.
  std::size_t stride_;
  std::size_t blocks_;  // a row
  std::size_t chunks_;  // 64 blocks each, a row
  std::int32_t rows_;
  std::vector<std::uint32_t> cells_;
  std::vector<std::uint8_t> used_;  // a byte for each block, 0 or 1; whole chunks a row
};

}  // namespace contourd
