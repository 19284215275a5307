// Writes files that are complete or absent, even after a power cut. Blocks until the data is on the disk.
// Thread-safe.
#pragma once

#include <filesystem>
#include <string_view>

namespace contourd {

// Writes an unnamed file, or one with an unpredictable name, and renames it to `path`. Throws
// std::system_error; then the previous file is unchanged.
void write_durably(const std::filesystem::path& path, std::string_view text);

// Flushes a folder's renames to the disk. Does nothing if the file system cannot do it.
void sync_folder(const std::filesystem::path& folder);

// Flushes what others have written to the disk: one file, or all files directly in a folder. Ignores what
// cannot be opened or flushed.
void sync_contents(const std::filesystem::path& path);

}  // namespace contourd
