// The light by a GPIO line. Event loop's thread only.
#pragma once

#include <string>

#include "hw/gpio/gpio_lines.hpp"
#include "hw/light_line.hpp"

namespace contourd {

class GpioLightLine final : public LightLine {
 public:
  // Takes the line, dark. Throws HardwareError.
  explicit GpioLightLine(const GpioLineConfig& config);

  void on() override;
  void off() noexcept override;

 private:
  std::string words_;
  GpioOutput line_;
};

}  // namespace contourd
