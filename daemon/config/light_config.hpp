// What turns a machine's light off, for a process that comes after one which has died: from the record that
// this one has left, or else from as much of a printer's file as is sound. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// The record's text (JSON). `table` is that of the projector's section, where it names one, as in its file.
// The printer's file is sound, and its "hardware" is "real". REQUIRES: it has its section "projector".
[[nodiscard]] std::string light_record(const JsonDocument& printer,
                                       const std::optional<nlohmann::json>& table);

// The record of a contourd that ends in order, with the light confirmed off. REQUIRES: a record's text.
[[nodiscard]] std::string left_dark(const std::string& record);

// Throws ConfigError when it is no such record.
[[nodiscard]] LightConfig read_light_record(const std::filesystem::path& record);

struct FoundLight {
  LightConfig light;  // empty for a simulated machine
  std::optional<std::filesystem::path> control_socket;
  std::vector<Violation> problems;   // with what turns the light off: `light` may not be all of it
  std::vector<Violation> elsewhere;  // what else is wrong in the files that were read
};

// Reads of a printer's file, and of its projector's table, what turns the light off. Whatever is wrong, what
// can be had is returned.
[[nodiscard]] FoundLight find_light(const std::filesystem::path& printer_file);

}  // namespace contourd
