// Reads what a real machine is made of from a printer's file. Pure functions of the document.
#pragma once

#include <optional>

#include "daemon/json/json_section.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Throws ConfigError, also where the section lacks a default.
[[nodiscard]] GpioLineConfig read_gpio_line(const JsonSection& line);

// `table` is that of the projector's section, where it names one. What printer_schema() and the rules of
// hardware_rules.hpp look at is not looked at again. Throws ConfigError where a key is missing.
[[nodiscard]] RealMachineConfig read_real_machine(const JsonSection& printer,
                                                  std::optional<ProjectorTable> table);

}  // namespace contourd
