// Writes and reads masks as PNG files (8-bit grey). Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/image/mask_png.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// Writes a mask to a file. Blocks. Throws std::system_error if the file cannot be written; a half-written
// regular file is removed.
void write_png(const std::filesystem::path& path, const Mask& mask);
// Writes a mask like the function above, with an encoder whose memory is reused for many files.
void write_png(const std::filesystem::path& path, const Mask& mask, MaskPngEncoder& encoder);

// Reads a mask from a file. Blocks. Throws std::system_error if the file cannot be read, and
// std::runtime_error, whose what() is one clause without the path, if it is not a PNG of 8-bit grey without
// transparency, is damaged, has a side longer than a mask's or more than 128 MiB.
[[nodiscard]] Mask read_png(const std::filesystem::path& path);

// Reads any PNG as 8-bit grey: colours become their lightness, transparent pixels are drawn over black.
// Otherwise like read_png().
[[nodiscard]] Mask read_png_as_grey(const std::filesystem::path& path);

// A row of a picture: `channels` samples a pixel, grey or red, green and blue, from 0 to 65535.
struct PngRow {
  std::int32_t y = 0;
  std::span<const std::uint16_t> samples;
  std::size_t channels = 0;
};

// Reads a photo of any PNG kind row by row, so that it is never in memory as a whole, and calls `take` for
// each row. Samples are those of the file, without regard to its gamma and transparency; those of fewer bits
// are scaled to 16. Throws as read_png() does, also if the picture is interlaced or has more than 100 million
// pixels.
void read_png_rows(const std::filesystem::path& path, const std::function<void(const PngRow&)>& take);

// Decodes the bytes of a PNG file by read_png()'s rules. A picture that does not have this size is rejected
// before its pixels are read. Does not block.
[[nodiscard]] Mask decode_png(std::span<const std::uint8_t> bytes, Pixels width, Pixels height);

// Returns the bytes that write_png() would write; with a palette, those of a colour picture.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Mask& mask, const Palette* palette = nullptr);

}  // namespace contourd
