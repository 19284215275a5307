// Reads a projector's table, a file of config/projectors/ that describes its serial protocol. Thread-safe.
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

// Reads a table. Throws ConfigError with all violations: invalid patterns and bytes, wrong checksums,
// commands that require another command.
[[nodiscard]] ProjectorTable load_projector_table(const std::filesystem::path& path);
// Reads a table that check_table() found valid. Throws ConfigError if a key is missing.
[[nodiscard]] ProjectorTable read_projector_table(const JsonSection& table);

// Adds the table's violations to its document and sets missing keys to their defaults.
void check_table(JsonDocument& document);
// Reads only the commands that turn the light off and, if valid, ask whether the projector is on. Returns
// nullopt if the table cannot switch the light. Throws ConfigError, also if a key that has a default is
// missing, or std::invalid_argument.
[[nodiscard]] std::optional<ProjectorTable> read_light_table(const JsonSection& table);

}  // namespace contourd
