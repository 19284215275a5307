// The config of one GPIO line. Value type.
#pragma once

#include <string>

namespace contourd {

struct GpioLineConfig {
  std::string chip = "gpiochip0";  // device name below /dev, a path, or the chip's label ("pinctrl-bcm2711")
  std::string line;                // its number on that chip ("17"), or its name ("GPIO17")
  bool active_low = false;         // "on", "closed", "enabled" is the low level
};

enum class LineBias { AsIs, PullUp, PullDown, Off };

}  // namespace contourd
