// Reads the hardware of a real machine from a printer's file. Pure functions of the document.
#pragma once

#include <optional>

#include "daemon/json/json_section.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Reads a GPIO line. Throws ConfigError, also if a key that has a default is missing.
[[nodiscard]] GpioLineConfig read_gpio_line(const JsonSection& line);

// Reads the hardware but for the projector. Does not repeat the checks of printer_schema() and
// hardware_rules.hpp. Throws ConfigError if a key is missing.
[[nodiscard]] RealMachineConfig read_real_machine(const JsonSection& printer,
                                                  std::optional<ProjectorConfig> projector);

}  // namespace contourd
