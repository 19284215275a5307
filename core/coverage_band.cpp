#include "core/coverage_band.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

namespace contourd {
namespace {

constexpr std::size_t kBlock = CoverageBand::kBlock;
constexpr std::size_t kChunk = kBlock * kBlock;

// Cells of one band: 256 KB, a quarter of a Cortex-A72's second cache.
constexpr std::size_t kBandCells = std::size_t{1} << 15;
constexpr std::size_t kFewestRows = 2;

static_assert(std::endian::native == std::endian::little, "take_used() reads eight bytes as one word");

std::uint8_t grey_of(std::uint32_t winding) {
  constexpr std::uint32_t one = CoverageBand::kOne;
  const auto sign =
      static_cast<std::uint32_t>(static_cast<std::int32_t>(winding) >> 31);  // all ones when negative
  const std::uint32_t magnitude = (winding ^ sign) - sign;
  return static_cast<std::uint8_t>((std::min(magnitude, one) * 255U + one / 2) >> CoverageBand::kOneBits);
}

// Ones from bit `from` up to, not including, bit `to`.
std::uint64_t bits_between(std::size_t from, std::size_t to) {
  const std::uint64_t below_to = to < 64 ? (std::uint64_t{1} << to) - 1 : ~std::uint64_t{0};
  return from < 64 ? below_to & (~std::uint64_t{0} << from) : 0;
}

// Makes the given blocks of a chunk one grey value.
void fill_blocks(std::uint64_t blocks, std::uint8_t grey, std::size_t chunk, std::span<std::uint8_t> pixels) {
  while (blocks != 0) {
    // Runs of neighbours at once.
    const auto first = static_cast<std::size_t>(std::countr_zero(blocks));
    const auto count = static_cast<std::size_t>(std::countr_one(blocks >> first));
    const std::size_t begin = chunk * kChunk + first * kBlock;
    std::memset(pixels.data() + begin, grey, std::min(count * kBlock, pixels.size() - begin));
    blocks &= ~bits_between(first, first + count);
  }
}

// One chunk's state while its row is painted.
struct ChunkState {
  std::uint64_t dark, full;

  // Gives those of the blocks that are not so already.
  std::uint64_t make(std::uint64_t blocks, std::uint8_t grey) {
    const std::uint64_t to_write = grey == 0 ? blocks & ~dark : grey == 255 ? blocks & ~full : blocks;
    dark = grey == 0 ? dark | blocks : dark & ~blocks;
    full = grey == 255 ? full | blocks : full & ~blocks;
    return to_write;
  }
};

}  // namespace

CoverageBand::CoverageBand(std::int32_t width)
    : stride_((static_cast<std::size_t>(width) + 1 + kBlock - 1) / kBlock * kBlock),
      blocks_(stride_ / kBlock),
      chunks_((blocks_ + kBlock - 1) / kBlock),
      rows_(static_cast<std::int32_t>(std::bit_floor(std::max(kFewestRows, kBandCells / stride_)))) {
  const auto rows = static_cast<std::size_t>(rows_);
  cells_.assign(rows * stride_, 0);
  touched_.assign(rows * blocks_, 0);
  used_.assign(rows * chunks_ * kBlock, 0);
  columns_.resize(kChunk + 4);
}

// A bit for each block of the chunk that is in use; none is after that.
std::uint64_t CoverageBand::take_used(std::size_t row, std::size_t chunk) {
  std::uint8_t* const bytes = used_.data() + (row * chunks_ + chunk) * kBlock;
  std::uint64_t used = 0;
  const std::size_t blocks = std::min(blocks_ - chunk * kBlock, kBlock);
  for (std::size_t i = 0; i < blocks; i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, bytes + i, sizeof eight);
    // Byte k's lowest bit comes to lie in bit 56 + k of the product, without any carry.
    used |= (eight * 0x0102040810204080U >> 56) << i;
  }
  if (used != 0) std::memset(bytes, 0, kBlock);
  return used;
}

// The columns that hold something in the blocks of `used`, and each such block's first. Few branches: how
// many columns a block has cannot be foreseen, and a wrong guess costs more than handling four.
inline std::size_t CoverageBand::take_columns(std::size_t row, std::size_t chunk, std::uint64_t used) {
  std::size_t count = 0;
  for (; used != 0; used &= used - 1) {
    const std::size_t block = chunk * kBlock + static_cast<std::size_t>(std::countr_zero(used));
    std::uint64_t bits = std::exchange(touched_[row * blocks_ + block], 0) | 1;
    for (int i = 0; i < 4; ++i) {
      columns_[count] =
          static_cast<std::uint16_t>(block * kBlock + static_cast<std::size_t>(std::countr_zero(bits)));
      count += bits != 0;
      bits &= bits - 1;
    }
    for (; bits != 0; bits &= bits - 1) {
      columns_[count++] =
          static_cast<std::uint16_t>(block * kBlock + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
  return count;
}

// Paints these columns, and after each what follows it, up to the end of its block at least; forgets their
// cells. Gives the winding number at the end.
inline std::uint32_t CoverageBand::paint_columns(std::size_t row, std::span<const std::uint16_t> columns,
                                                 std::uint32_t winding, std::span<std::uint8_t> pixels) {
  std::uint64_t* const cells = cells_.data() + row * stride_;
  const std::size_t width = pixels.size();
  // Gives the grey of the column itself.
  const auto take = [cells, &winding](std::size_t column) {
    const std::uint64_t cell = std::exchange(cells[column], 0U);
    const auto share = static_cast<std::uint32_t>(cell);
    const std::uint8_t grey = grey_of(winding + share);
    // The share's sign has borrowed from the cover's half.
    winding += static_cast<std::uint32_t>(cell >> 32) + (share >> 31);
    return grey;
  };
  // Always a block's length: what lies beyond the block has the same grey, up to the next column, which
  // paints over it.
  std::size_t i = 0;
  for (; i < columns.size() && columns[i] + kBlock < width; ++i) {
    std::uint8_t* const pixel = pixels.data() + columns[i];
    *pixel = take(columns[i]);
    std::memset(pixel + 1, grey_of(winding), kBlock);
  }
  for (; i < columns.size(); ++i) {
    const std::size_t column = columns[i];
    const std::uint8_t grey = take(column);
    if (column >= width) continue;
    pixels[column] = grey;
    std::memset(pixels.data() + column + 1, grey_of(winding), width - column - 1);
  }
  return winding;
}

void CoverageBand::paint(std::int32_t row_number, std::span<std::uint8_t> pixels, RowBlocks state) {
  const auto row = static_cast<std::size_t>(row_number);
  const std::size_t pixel_blocks = (pixels.size() + kBlock - 1) / kBlock;
  std::uint32_t winding = 0;
  for (std::size_t chunk = 0; chunk < chunks_; ++chunk) {
    const std::size_t first_block = chunk * kBlock;
    const std::uint64_t used = take_used(row, chunk);
    const std::uint8_t first_grey = grey_of(winding);
    winding = paint_columns(row, std::span(columns_).first(take_columns(row, chunk, used)), winding, pixels);
    ChunkState blocks{state.dark[chunk] & ~used, state.full[chunk] & ~used};
    // The runs of blocks between those in use. The last chunk may hold a block without pixels.
    const std::uint64_t unused = ~used & bits_between(0, std::min(pixel_blocks - first_block, kBlock));
    for (std::uint64_t rest = unused; rest != 0;) {
      const auto first = static_cast<std::size_t>(std::countr_zero(rest));
      const std::uint64_t run =
          bits_between(first, first + static_cast<std::size_t>(std::countr_one(rest >> first)));
      // The last column before the run has painted its first pixel.
      const std::uint8_t grey = first == 0 ? first_grey : pixels[(first_block + first) * kBlock];
      const std::uint64_t to_write = blocks.make(run, grey);
      if (to_write != 0) fill_blocks(to_write, grey, chunk, pixels);
      rest &= ~run;
    }
    state.dark[chunk] = blocks.dark;
    state.full[chunk] = blocks.full;
  }
}

}  // namespace contourd
