// Reads a real machine's projector, of any kind, from a printer's file or from the light record. Thread-safe
// (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Returns the keys of the printer's section "projector" that each name something to switch the light with.
[[nodiscard]] std::span<const char* const> light_keys();

// Reads the table that the printer's file names; adds a violation if it does not exist. Returns nullopt if
// there is none. The content is not checked. Throws ConfigError if the table is not JSON.
[[nodiscard]] std::optional<JsonDocument> named_table(JsonDocument& printer,
                                                      const std::filesystem::path& folder);

// Reads a projector. `section` is the printer's section "projector", or the light record; `table` is the
// content of the table that it names, if any. Returns nullopt if the light is only a line. Throws ConfigError
// if a key is missing.
[[nodiscard]] std::optional<ProjectorConfig> read_projector(const JsonSection& section,
                                                            const std::optional<JsonSection>& table);

// Like read_projector(), but reads only what is needed to turn the light off, and returns nullopt if the
// projector cannot do that. Throws ConfigError or std::invalid_argument.
[[nodiscard]] std::optional<ProjectorConfig> read_light_projector(const JsonSection& section,
                                                                  const std::optional<JsonSection>& table);

}  // namespace contourd
