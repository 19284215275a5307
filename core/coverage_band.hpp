// The rows that the rasterizer works on at a time: what its sides add to each pixel, and the painting of it.
// Small enough to stay in the cache, whatever the display's size.
//
// A pixel's cell has two sums: by how much the sides that pass the pixel change the winding number, averaged
// over this pixel (`share`), and for all pixels right of it (`cover`). One sum along the row gives every
// pixel's winding. Of each block of 64 pixels one word tells which cells are in use, and one byte whether
// any is, so that painting visits only what a side has touched. Not thread-safe;
// allocates in its constructor only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace contourd {

// What the blocks of one mask row hold at present, a bit a block, 64 blocks a word: all 0, or all 255.
struct RowBlocks {
  std::span<std::uint64_t> dark, full;
};

class CoverageBand {
 public:
  // The winding number one in the units of the sums: up to 65,535 polygons may overlap in a pixel.
  static constexpr int kOneBits = 15;
  static constexpr std::int32_t kOne = 1 << kOneBits;
  static constexpr std::size_t kBlock = 64;  // pixels

  explicit CoverageBand(std::int32_t width);

  // How many rows it holds: a power of two.
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  // Words in each span of RowBlocks.
  [[nodiscard]] std::size_t chunks() const { return chunks_; }

  // Both sums in one word, so that they are added at once.
  [[nodiscard]] static constexpr std::uint64_t cell(std::int32_t cover, std::int32_t share) {
    return (static_cast<std::uint64_t>(cover) << 32) +
           static_cast<std::uint64_t>(static_cast<std::int64_t>(share));
  }

  // A row's cells, to be added to. Valid as long as the band.
  class Row {
   public:
    // REQUIRES: 0 <= column <= width. Unsigned: wraps instead of overflowing when more polygons overlap than
    // the sums can hold.
    void add(std::size_t column, std::uint64_t cell) const {
      cells_[column] += cell;
      touched_[column / kBlock] |= std::uint64_t{1} << column % kBlock;
      used_[column / kBlock] = 1;
    }
    // To the row below. REQUIRES: there is one, or nothing is added any more.
    void step() {
      cells_ += band_->stride_;
      touched_ += band_->blocks_;
      used_ += band_->chunks_ * kBlock;
    }

   private:
    friend class CoverageBand;
    Row(CoverageBand& band, std::size_t row)
        : band_(&band),
          cells_(band.cells_.data() + row * band.stride_),
          touched_(band.touched_.data() + row * band.blocks_),
          used_(band.used_.data() + row * band.chunks_ * kBlock) {}

    const CoverageBand* band_;
    std::uint64_t* cells_;
    std::uint64_t* touched_;
    std::uint8_t* used_;
  };
  // REQUIRES: 0 <= row < rows().
  [[nodiscard]] Row row(std::int32_t row) { return {*this, static_cast<std::size_t>(row)}; }

  // Paints what was added to a row by the non-zero rule, and forgets it. `pixels` is the whole mask row,
  // which already is as `blocks` says; only blocks that change are written.
  void paint(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks);

 private:
  [[nodiscard]] std::uint64_t take_used(std::size_t row, std::size_t chunk);
  [[nodiscard]] std::size_t take_columns(std::size_t row, std::size_t chunk, std::uint64_t used);
  [[nodiscard]] std::uint32_t paint_columns(std::size_t row, std::span<const std::uint16_t> columns,
                                            std::uint32_t winding, std::span<std::uint8_t> pixels);

  // Cells a row: the display's columns, and one more that takes what lies on its right edge, up to whole
  // blocks.
  std::size_t stride_;
  std::size_t blocks_;  // a row
  std::size_t chunks_;  // 64 blocks each, a row
  std::int32_t rows_;
  std::vector<std::uint64_t> cells_;
  std::vector<std::uint64_t> touched_;  // a bit a column
  std::vector<std::uint8_t> used_;      // a byte a block, 0 or 1, whole chunks a row
  std::vector<std::uint16_t> columns_;  // in use, while a chunk is painted
};

}  // namespace contourd
