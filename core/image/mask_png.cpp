#include "core/image/mask_png.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <tuple>

namespace contourd {
namespace {

// CRC tables: kCrcTables[k][b] is the effect of byte b on the checksum with k more bytes after it. PNG, annex
// D; eight bytes at a time as in Kounavis and Berry, "A Systematic Approach to Building High Performance
// Software-Based CRC Generators" (2005).
constexpr std::size_t kSlices = 8;
constexpr std::array<std::array<std::uint32_t, 256>, kSlices> kCrcTables = [] {
  std::array<std::array<std::uint32_t, 256>, kSlices> tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit)
      crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320U : 0U);
    tables[0][byte] = crc;
  }
  for (std::size_t k = 1; k < kSlices; ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte)
      tables[k][byte] = tables[k - 1][byte] >> 8 ^ tables[0][tables[k - 1][byte] & 0xFF];
  }
  return tables;
}();

std::uint32_t crc_of(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = ~0U;
  for (; bytes.size() >= kSlices; bytes = bytes.subspan(kSlices)) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < kSlices; ++i) {
      const std::uint32_t old = i < 4 ? crc >> (8 * i) : 0;
      next ^= kCrcTables[kSlices - 1 - i][(bytes[i] ^ old) & 0xFF];
    }
    crc = next;
  }
  for (const std::uint8_t byte : bytes)
    crc = crc >> 8 ^ kCrcTables[0][(crc ^ byte) & 0xFF];
  return ~crc;
}

constexpr std::size_t kSignature = 8;
// Bytes of a chunk's length, name and checksum.
constexpr std::size_t kLength = 4, kName = 4, kCrc = 4;
constexpr std::size_t kChunk = kLength + kName + kCrc;
constexpr std::size_t kHeader = 13;
constexpr std::size_t kDataChunk = kSignature + kChunk + kHeader;
constexpr std::size_t kData = kDataChunk + kLength + kName;
constexpr std::size_t kPaletteBytes = 3 * std::tuple_size_v<Palette>;

enum class Filter : std::uint8_t { None = 0, Up = 2 };

void write_number(std::uint8_t* at, std::size_t number) {
  for (int i = 0; i < 4; ++i)
    at[i] = static_cast<std::uint8_t>(number >> (24 - 8 * i));
}

// Writes the length, name and checksum around `size` bytes that are already there; returns the chunk's end.
std::uint8_t* close_chunk(std::uint8_t* chunk, std::string_view name, std::size_t size) {
  write_number(chunk, size);
  std::copy_n(name.begin(), kName, chunk + kLength);
  write_number(chunk + kLength + kName + size, crc_of({chunk + kLength, kName + size}));
  return chunk + kChunk + size;
}

void write_header(std::uint8_t* at, const Mask& mask, const Palette* palette) {
  constexpr std::uint8_t kStart[kSignature] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  // Deflate, a filter for each row, not interlaced.
  constexpr std::uint8_t kGrey8[] = {8, 0, 0, 0, 0}, kIndexed8[] = {8, 3, 0, 0, 0};
  std::uint8_t* header = std::copy_n(kStart, kSignature, at) + kLength + kName;
  write_number(header, static_cast<std::size_t>(mask.width().count()));
  write_number(header + 4, static_cast<std::size_t>(mask.height().count()));
  std::copy_n(palette == nullptr ? kGrey8 : kIndexed8, sizeof kGrey8, header + 8);
  std::uint8_t* chunk = close_chunk(at + kSignature, "IHDR", kHeader);
  if (palette == nullptr) return;
  std::uint8_t* color = chunk + kLength + kName;
  for (const Rgb& each : *palette) {
    *color++ = each.red;
    *color++ = each.green;
    *color++ = each.blue;
  }
  close_chunk(chunk, "PLTE", kPaletteBytes);
}

// Returns the first pixel after `at` that differs from it, or `width`.
std::size_t end_of_run(const std::uint8_t* pixels, std::size_t at, std::size_t width) {
  const std::uint8_t grey = pixels[at++];
  if (at == width || pixels[at] != grey) return at;
  constexpr std::size_t kBlock = 64;  // a few vectors, which compilers compare whole
  for (; at + kBlock <= width; at += kBlock) {
    std::uint8_t difference = 0;
    for (std::size_t i = 0; i < kBlock; ++i)
      difference |= pixels[at + i] ^ grey;
    if (difference != 0) break;
  }
  const std::uint64_t same = grey * 0x0101010101010101U;
  for (std::uint64_t eight; at + sizeof eight <= width; at += sizeof eight) {
    std::memcpy(&eight, pixels + at, sizeof eight);
    const std::uint64_t difference = eight ^ same;
    if (difference == 0) continue;
    const int equal_bits = std::endian::native == std::endian::little ? std::countr_zero(difference)
                                                                      : std::countl_zero(difference);
    return at + static_cast<std::size_t>(equal_bits) / 8;
  }
  while (at < width && pixels[at] == grey)
    ++at;
  return at;
}

// Adds the row's runs and returns true if the whole row is dark.
bool deflate_row(std::span<const std::uint8_t> row, RunDeflater& deflater) {
  std::size_t at = 0;
  do {
    const std::size_t end = end_of_run(row.data(), at, row.size());
    deflater.add(row[at], end - at);
    if (end == row.size()) return at == 0 && row[at] == 0;
    at = end;
  } while (true);
}

}  // namespace

std::span<const std::uint8_t> MaskPngEncoder::encode(const Mask& mask, const Palette* palette) {
  if (mask.pixels().empty()) throw std::invalid_argument("a picture has at least one pixel");
  const std::size_t before = palette == nullptr ? 0 : kChunk + kPaletteBytes;
  deflater_.begin(bytes_, before + kData);
  deflate_rows(mask);
  const std::size_t end = deflater_.finish();
  bytes_.resize(std::max(bytes_.size(), end + kCrc + kChunk));
  write_header(bytes_.data(), mask, palette);
  std::uint8_t* last = close_chunk(bytes_.data() + before + kDataChunk, "IDAT", end - kData - before);
  close_chunk(last, "IEND", 0);
  return std::span(bytes_).first(end + kCrc + kChunk);
}

void MaskPngEncoder::deflate_rows(const Mask& mask) {
  const std::size_t width = mask.row(0).size();
  bool dark_above = true;  // dark rows are shortest unfiltered: a single run including the filter's byte
  for (std::int32_t y = 0; y < mask.height().count(); ++y) {
    const std::span<const std::uint8_t> row = mask.row(y);
    if (!dark_above && std::memcmp(row.data(), row.data() - width, width) == 0) {
      deflater_.add(static_cast<std::uint8_t>(Filter::Up), 1);
      deflater_.add(0, width);
    } else {
      deflater_.add(static_cast<std::uint8_t>(Filter::None), 1);
      dark_above = deflate_row(row, deflater_);
    }
  }
}

}  // namespace contourd
