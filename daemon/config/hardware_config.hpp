// Reads what a real machine is made of from a printer's file. Pure functions of the document.
#pragma once

#include <optional>

#include "daemon/config/json_section.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Throws ConfigError. REQUIRES: the section has its defaults.
[[nodiscard]] GpioLineConfig read_gpio_line(const JsonSection& line);

// `table` is that of the projector's section, where it names one. REQUIRES: printer_schema() and the rules of
// hardware_rules.hpp found the printer's file good, and its "hardware" is "real".
[[nodiscard]] RealMachineConfig read_real_machine(const JsonSection& printer,
                                                  std::optional<ProjectorTable> table);

}  // namespace contourd
