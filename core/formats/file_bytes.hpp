// Reads of an open file that end completely or with an exception. Thread-safe (no shared state).
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace contourd {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, CloseFile>;

// Opens a regular file for reading. Throws std::system_error if it cannot be read or is not a regular file.
[[nodiscard]] OpenFile open_regular(const std::filesystem::path& path);

// Fills the span with the next bytes of the file; `path` is the file's name in messages. Throws
// std::system_error if the file cannot be read or ends before.
void read_exactly(std::FILE* file, std::span<std::byte> into, const std::filesystem::path& path);

// Returns the first bytes of a file of `bytes` bytes, by which its format is recognised, and leaves the file
// at its beginning. Throws std::system_error.
[[nodiscard]] std::vector<std::byte> read_start(std::FILE* file, std::uint64_t bytes,
                                                const std::filesystem::path& path);

}  // namespace contourd
