// Writes masks as PNG files (8-bit grey). Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/mask.hpp"

namespace contourd {

// Blocks. Throws std::system_error when the file cannot be written; a regular file half written is
// removed.
void write_png(const std::filesystem::path& path, const Mask& mask);

// The same PNG in memory.
[[nodiscard]] std::vector<std::uint8_t> encode_png(const Mask& mask);

}  // namespace contourd
