// What a computer says of itself that matters to a printer, as text. Changes nothing and takes no device.
// What cannot be read says why. Not thread-safe.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/system/regular_file.hpp"

namespace contourd::ctl {

// So many bytes of a regular file at most. Throws UnreadableFile.
[[nodiscard]] std::string beginning_of(const std::filesystem::path& file, std::size_t most, Links links);

// What is in it, in order, and only the first of very many. Nothing where it cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> entries_of(const std::filesystem::path& folder);
// A kernel's or system's file, without the line breaks at its end; why it cannot be read in its place.
[[nodiscard]] std::string text_of(const std::filesystem::path& file);
// Of what it leads to; empty when it is no link.
[[nodiscard]] std::string name_of_link(const std::filesystem::path& link);

// contourctl's, the system's, the packages'.
[[nodiscard]] std::string versions();
// Kernel, computer, memory; not the computer's name.
[[nodiscard]] std::string kernel_facts();
// Connectors with state and modes.
[[nodiscard]] std::string display_facts();
// Chips with their lines, and who holds them.
[[nodiscard]] std::string gpio_facts();
// Serial ports with their drivers and makers; not their serial numbers.
[[nodiscard]] std::string serial_facts();

}  // namespace contourd::ctl
