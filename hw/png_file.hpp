// Masks as PNG files (8-bit grey), written and read. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/image/mask_png.hpp"
#include "core/mask/mask.hpp"

namespace contourd {

// Blocks. Throws std::system_error when the file cannot be written; a regular file half written is
// removed.
void write_png(const std::filesystem::path& path, const Mask& mask);
// The same with an encoder whose memory serves for many files.
void write_png(const std::filesystem::path& path, const Mask& mask, MaskPngEncoder& encoder);

// Reads one. Blocks. Throws std::system_error when the file cannot be read, and std::runtime_error, whose
// what() is one clause without the path, when it is no PNG of 8-bit grey without transparency, is damaged,
// has a side longer than a mask's or more than 128 MiB.
[[nodiscard]] Mask read_png(const std::filesystem::path& path);

// Reads any PNG as 8-bit grey: colours by their lightness, what is transparent over black. The same
// otherwise.
[[nodiscard]] Mask read_png_as_grey(const std::filesystem::path& path);

// The picture of a file's bytes, by read_png()'s rules, where it must be of this size: else it is not read.
// Does not block.
[[nodiscard]] Mask decode_png(std::span<const std::uint8_t> bytes, Pixels width, Pixels height);

// The same PNG in memory; coloured where there is a palette.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Mask& mask, const Palette* palette = nullptr);

}  // namespace contourd
