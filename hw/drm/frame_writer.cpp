#include "hw/drm/frame_writer.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr bool rounds_to_nearest() {
  for (int grey = 0; grey < 256; ++grey) {
    const int five = (2 * grey * 31 + 255) / 510, six = (2 * grey * 63 + 255) / 510;
    if (rgb565(static_cast<std::uint8_t>(grey)) != (five << 11 | six << 5 | five)) return false;
  }
  return true;
}
static_assert(rounds_to_nearest());

template <PixelFormat kFormat>
using Word = std::conditional_t<kFormat == PixelFormat::Xrgb8888, std::uint32_t, std::uint16_t>;

template <PixelFormat kFormat>
Word<kFormat> word_of(std::uint8_t grey) {
  if constexpr (kFormat == PixelFormat::Xrgb8888) {
    return xrgb8888(grey);
  } else {
    return rgb565(grey);
  }
}

// The number of pixels is constant, so that the loop compiles to a few vector instructions and the copy to
// wide stores.
template <PixelFormat kFormat, std::size_t kPixels>
void write_block(const std::uint8_t* grey, std::byte* to) {
  Word<kFormat> words[kPixels];
  for (std::size_t i = 0; i < kPixels; ++i)
    words[i] = word_of<kFormat>(grey[i]);
  std::memcpy(to, words, sizeof words);
}

// Writes the blocks of a row that differ from its content. Returns the number of bytes written.
template <PixelFormat kFormat>
std::size_t write_row(std::span<const std::uint8_t> row, std::span<std::uint8_t> content, std::byte* to) {
  constexpr std::size_t kBlock = FrameWriter::kBlock, kWord = sizeof(Word<kFormat>);
  std::size_t written = 0, x = 0;
  for (; x + kBlock <= row.size(); x += kBlock) {
    if (std::memcmp(&row[x], &content[x], kBlock) == 0) continue;
    write_block<kFormat, kBlock>(&row[x], to + x * kWord);
    std::memcpy(&content[x], &row[x], kBlock);
    written += kBlock * kWord;
  }
  for (; x < row.size(); ++x) {  // the last block of an odd width
    if (row[x] == content[x]) continue;
    write_block<kFormat, 1>(&row[x], to + x * kWord);
    content[x] = row[x];
    written += kWord;
  }
  return written;
}

}  // namespace

FrameWriter::FrameWriter(const Layout& layout, std::span<std::byte> memory)
    : layout_(layout), memory_(memory), content_(layout.width, layout.height) {
  const std::size_t pixel =
      layout.format == PixelFormat::Xrgb8888 ? sizeof(std::uint32_t) : sizeof(std::uint16_t);
  expects(layout.stride_bytes >= pixel * static_cast<std::size_t>(layout.width.count()),
          "a row holds its pixels");
  expects(memory.size() >= layout.stride_bytes * static_cast<std::size_t>(layout.height.count()),
          "the memory holds all rows");
  expects(reinterpret_cast<std::uintptr_t>(memory.data()) % pixel == 0,
          "the memory is aligned to a pixel's size");
  blacken();
}

std::size_t FrameWriter::write(const Mask& mask) noexcept {
  expects(mask.width() == layout_.width && mask.height() == layout_.height, "the mask has the layout's size");
  return layout_.format == PixelFormat::Xrgb8888 ? write_as<PixelFormat::Xrgb8888>(mask)
                                                 : write_as<PixelFormat::Rgb565>(mask);
}

void FrameWriter::blacken() noexcept {
  std::memset(memory_.data(), 0, memory_.size());
  for (std::int32_t y = 0; y < layout_.height.count(); ++y)
    std::ranges::fill(content_.row(y), std::uint8_t{0});
}

template <PixelFormat kFormat>
std::size_t FrameWriter::write_as(const Mask& mask) noexcept {
  std::size_t written = 0;
  std::byte* to = memory_.data();
  for (std::int32_t y = 0; y < layout_.height.count(); ++y, to += layout_.stride_bytes) {
    const auto row = mask.row(y);
    const auto content = content_.row(y);
    if (std::memcmp(row.data(), content.data(), row.size()) == 0) continue;
    written += write_row<kFormat>(row, content, to);
  }
  return written;
}

}  // namespace contourd
