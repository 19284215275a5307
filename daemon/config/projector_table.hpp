// Reads what a make of projector speaks from its file in config/projectors/. Thread-safe.
#pragma once

#include <filesystem>

#include "hw/serial/projector_table.hpp"

namespace contourd {

// Throws ConfigError with everything that is wrong with the table: patterns and bytes that cannot be read,
// checksums that are not right, commands that need one another.
[[nodiscard]] ProjectorTable load_projector_table(const std::filesystem::path& path);

}  // namespace contourd
