// Reads the hardware of a real machine from a printer's file, and checks the rules for it that a schema
// cannot express: required keys and conflicts between keys. Thread-safe for different documents.
#pragma once

#include <optional>

#include "daemon/json/json_document.hpp"
#include "daemon/json/json_section.hpp"
#include "hw/real_machine_config.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

// Reads a GPIO line. Throws ConfigError, also if a key that has a default is missing.
[[nodiscard]] GpioLineConfig read_gpio_line(const JsonSection& line);

// Reads the hardware but for the projector. Does not repeat the checks of printer_schema() and
// check_hardware_rules(). Throws ConfigError if a key is missing.
[[nodiscard]] RealMachineConfig read_real_machine(const JsonSection& printer,
                                                  std::optional<ProjectorConfig> projector);

// Adds violations to the printer's document. Keys that only a real machine needs are required only if
// "hardware" is "real", but are checked whenever they are present, so that one file serves both. Call it
// after printer_schema(); it ignores values that the schema has already rejected.
void check_hardware_rules(JsonDocument& printer);
// Adds the violations that depend on the projector's table.
void check_projector_table(JsonDocument& printer, const ProjectorTable& table);

}  // namespace contourd
