#include "core/mask/coverage_band.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace contourd {
namespace {

constexpr std::size_t kChunk = CoverageBand::kBlock * CoverageBand::kChunkBlocks;

// The number of cells in a band: 128 KB, an eighth of a Cortex-A72's second-level cache.
constexpr std::size_t kBandCells = std::size_t{1} << 15;
constexpr std::size_t kFewestRows = 2;

// Returns `count` ones, from bit 0 on.
std::uint64_t first_bits(std::size_t count) {
  return count < 64 ? (std::uint64_t{1} << count) - 1 : ~std::uint64_t{0};
}

using Block = std::array<std::uint8_t, CoverageBand::kBlock>;

// Copies a block to its place in a row. The last block of a row may have fewer pixels, or none.
inline void put_block(const Block& block, std::span<std::uint8_t> pixels, std::size_t begin) {
  if (begin + block.size() <= pixels.size()) {
    std::memcpy(pixels.data() + begin, block.data(), block.size());
  } else if (begin < pixels.size()) {
    std::memcpy(pixels.data() + begin, block.data(), pixels.size() - begin);
  }
}

// Fills the given blocks of a chunk with one grey value.
inline void fill_blocks(std::uint64_t blocks, std::uint8_t grey, std::span<std::uint8_t> pixels) {
  Block block;
  block.fill(grey);
  for (; blocks != 0; blocks &= blocks - 1)
    put_block(block, pixels, static_cast<std::size_t>(std::countr_zero(blocks)) * block.size());
}

}  // namespace

CoverageBand::CoverageBand(std::int32_t width)
    : stride_((static_cast<std::size_t>(width) + 3 + kBlock - 1) / kBlock * kBlock),
      blocks_(stride_ / kBlock),
      chunks_((blocks_ + kChunkBlocks - 1) / kChunkBlocks),
      rows_(static_cast<std::int32_t>(std::bit_floor(std::max(kFewestRows, kBandCells / stride_)))) {
  const auto rows = static_cast<std::size_t>(rows_);
  cells_.assign(rows * stride_, 0);
  used_.assign(rows * used_stride(), 0);
}

// Returns a bit for each used block of the chunk, and marks them all unused.
inline std::uint64_t CoverageBand::take_used(std::size_t row, std::size_t chunk) {
  std::uint8_t* const bytes = used_.data() + row * used_stride() + chunk * kChunkBlocks;
  const std::uint64_t used = bits_of(bytes);
  std::memset(bytes, 0, kChunkBlocks);
  return used;
}

// `winding`: a winding number of 0, as `paint_block_of` represents it.
template <typename PaintBlock>
inline void CoverageBand::paint_row(std::size_t row, std::span<std::uint8_t> row_pixels, RowBlocks state,
                                    std::uint32_t winding, PaintBlock&& paint_block_of) {
  std::uint8_t grey = 0;  // grey value of the present winding number
  Block block;
  for (std::size_t chunk = 0; chunk < chunks_; ++chunk) {
    // The last chunk may hold cells without pixels.
    const auto pixels = row_pixels.subspan(std::min(chunk * kChunk, row_pixels.size()));
    const std::uint64_t blocks = first_bits((pixels.size() + kBlock - 1) / kBlock);
    const std::uint64_t used = take_used(row, chunk);
    std::uint32_t* const cells = cells_.data() + row * stride_ + chunk * kChunk;
    // Values of the unused blocks: each continues as the block left of it ends.
    std::uint64_t dark = 0, full = 0;
    const auto hold = [&](std::uint64_t gap) {
      dark |= grey == 0 ? gap : 0;
      full |= grey == 255 ? gap : 0;
      if (grey != 0 && grey != 255) fill_blocks(gap, grey, pixels);
    };
    std::uint64_t done = 0;  // blocks done so far, from the left
    for (std::uint64_t rest = used; rest != 0; rest &= rest - 1) {
      const std::uint64_t lowest = rest & (0 - rest);
      hold((lowest - 1) & ~done);
      done = lowest | (lowest - 1);
      const std::size_t begin = static_cast<std::size_t>(std::countr_zero(rest)) * kBlock;
      winding = paint_block_of(cells + begin, winding, block.data());
      put_block(block, pixels, begin);
      grey = block.back();
    }
    hold(blocks & ~done);
    fill_blocks(dark & ~state.dark[chunk], 0, pixels);
    fill_blocks(full & ~state.full[chunk], 255, pixels);
    state.dark[chunk] = dark;
    state.full[chunk] = full;
  }
}

void CoverageBand::paint(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks) {
  paint_row(static_cast<std::size_t>(row), pixels, blocks, 0, paint_block);
}

void CoverageBand::paint_shared(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks,
                                SharedPixels& shared) {
  const std::uint32_t* const row_cells = cells_.data() + static_cast<std::size_t>(row) * stride_;
  paint_row(static_cast<std::size_t>(row), pixels, blocks, 0,
            [&](std::uint32_t* cells, std::uint32_t winding, std::uint8_t* block) {
              shared.look_at_block(row, static_cast<std::size_t>(cells - row_cells), cells, winding);
              return paint_block(cells, winding, block);
            });
}

bool CoverageBand::paint_covered(std::int32_t row, std::span<std::uint8_t> pixels, RowBlocks blocks) {
  WindingRange range;
  paint_row(static_cast<std::size_t>(row), pixels, blocks, kNoWinding,
            [&range](std::uint32_t* cells, std::uint32_t winding, std::uint8_t* block) {
              return paint_covered_block(cells, winding, block, range);
            });
  return range.is_zero_to_one();
}

}  // namespace contourd
