// Files by which a command tells other programs how contourd-web is set up: drop-ins of its units. Blocks
// until they are on the disk. Thread-safe (no state).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace contourd::web {

// Writes a file that everyone can read, and replaces an earlier one. Creates its folder. Throws OutputError
// with a sentence.
void write_setting(const std::filesystem::path& file, std::string_view text);
// Removes the file, if it is there. Throws OutputError with a sentence.
void remove_setting(const std::filesystem::path& file);

}  // namespace contourd::web
