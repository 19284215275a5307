// Facts about the computer that matter to a printer, as text. Only reads, and occupies no device. If a file
// cannot be read, the text has the reason in its place. Not thread-safe.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {

// Returns the beginning of a regular file, at most `most` bytes. Throws UnreadableFile.
[[nodiscard]] std::string beginning_of(const std::filesystem::path& file, std::size_t most, Links links);

// Returns the folder's entries, sorted, at most 256. Empty if the folder cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);
// Returns the text of a file of the kernel or the system without the line breaks at its end, or the reason in
// parentheses why it cannot be read.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);
// Returns the file name of the link's target, or an empty string if the file is not a link.
[[nodiscard]] std::string name_of_link(const std::filesystem::path& link);

// Returns the versions of contourctl, the system and its packages.
[[nodiscard]] std::string versions();
// Describes kernel, computer and memory, without the computer's name.
[[nodiscard]] std::string kernel_facts();
// Lists display connectors with their states and modes.
[[nodiscard]] std::string display_facts();
// Lists GPIO chips with their lines and consumers.
[[nodiscard]] std::string gpio_facts();
// Lists serial ports with their drivers and manufacturers, without serial numbers.
[[nodiscard]] std::string serial_facts();

}  // namespace contourd::ctl
