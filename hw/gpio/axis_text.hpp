// Texts for a line and a length in the axis' messages.
#pragma once

#include <cstdio>
#include <string>

#include "hw/gpio/gpio_line_config.hpp"

namespace contourd {

[[nodiscard]] inline std::string describe(const GpioLineConfig& line) {
  return "line " + line.line + " of " + line.chip;
}

[[nodiscard]] inline std::string millimeters(double mm) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f mm", mm);
  return text;
}

}  // namespace contourd
