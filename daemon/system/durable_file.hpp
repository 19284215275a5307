// Files that are either not there or whole, also after a power cut. Blocks until the disk has them.
// Thread-safe.
#pragma once

#include <filesystem>
#include <string_view>

namespace contourd {

// Writes a file of a name that nobody can know, or of none, and gives it this one. Throws std::system_error;
// then what was there before is still there.
void write_durably(const std::filesystem::path& path, std::string_view text);

// Has a folder's renames on the disk. Where a file system cannot, it is left to that file system.
void sync_folder(const std::filesystem::path& folder);

// Has what somebody else has written on the disk: a file, or all files of a folder (not of those in it). What
// cannot be opened or synchronized is left out.
void sync_contents(const std::filesystem::path& path);

}  // namespace contourd
