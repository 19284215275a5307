// A fault that ends a motion of the axis or prevents one, and texts for such messages. Values.
#pragma once

#include <cstdio>
#include <string>

#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

struct AxisFault {
  HomingResult homing = HomingResult::Fault;  // the result of a homing that it ends
  std::string what;                           // one sentence, with the line
  bool needs_user = false;                    // the emergency stop: nothing moves until the operator decides
};

[[nodiscard]] inline std::string describe(const GpioLineConfig& line) {
  return "line " + line.line + " of " + line.chip;
}

[[nodiscard]] inline std::string millimeters(double mm) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f mm", mm);
  return text;
}

}  // namespace contourd
