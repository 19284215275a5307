// Reads what a make of projector speaks from its file in config/projectors/. Thread-safe.
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

// Throws ConfigError with everything that is wrong with the table: patterns and bytes that cannot be read,
// checksums that are not right, commands that need one another.
[[nodiscard]] ProjectorTable load_projector_table(const std::filesystem::path& path);
// The same of a document; gives it its defaults.
[[nodiscard]] ProjectorTable read_projector_table(JsonDocument& document);

// Adds what is wrong with the table to its document, and gives that its defaults.
void check_table(JsonDocument& document);
// What of a table turns the light off, and asks whether the projector is on where that can be read; nothing
// where the table cannot switch the light. Looks at nothing else. Throws ConfigError,
// also where the table lacks a default, or std::invalid_argument.
[[nodiscard]] std::optional<ProjectorTable> read_light_table(const JsonSection& table);

}  // namespace contourd
