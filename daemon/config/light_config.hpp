// Finds the devices that turn a machine's light off, for a process that does so after contourd has died: from
// the light record that contourd left or, without one, from the valid parts of a printer's file. Thread-safe
// (no shared state).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Returns the text (JSON) of the light record: the printer's section "projector", with `table`, the content
// of the table that it names, if any. The printer's file must be valid, with the "hardware" "real". REQUIRES:
// it has a section "projector".
[[nodiscard]] std::string light_record(const JsonDocument& printer, const std::optional<JsonDocument>& table);

// Returns the record with the mark of a normal exit with the light confirmed off. REQUIRES: `record` is JSON
// text.
[[nodiscard]] std::string left_dark(const std::string& record);

// Reads a light record. Throws ConfigError if the file is not a valid one.
[[nodiscard]] LightConfig read_light_record(const std::filesystem::path& record);

struct FoundLight {
  LightConfig light;  // empty for a simulated machine
  std::optional<std::filesystem::path> control_socket;
  std::vector<Violation> problems;   // problems with turning the light off: `light` may be incomplete
  std::vector<Violation> elsewhere;  // other problems in the files that were read
};

// Finds what turns the light off in a printer's file and its projector's table. Never throws ConfigError:
// returns what is readable, with the problems.
[[nodiscard]] FoundLight find_light(const std::filesystem::path& printer_file);

}  // namespace contourd
