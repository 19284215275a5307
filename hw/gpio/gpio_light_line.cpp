#include "hw/gpio/gpio_light_line.hpp"

namespace contourd {

GpioLightLine::GpioLightLine(const GpioLineConfig& config)
    : words_("line " + config.line + " of " + config.chip), line_(config, "light", false) {}

void GpioLightLine::on() {
  if (!line_.set(true)) {
    off();
    throw HardwareError("the light's " + words_ + " cannot be set: the kernel refuses");
  }
}

void GpioLightLine::off() noexcept {
  (void)line_.set(false);
}

}  // namespace contourd
