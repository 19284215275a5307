#include "hw/gpio/line_descriptor.hpp"

#include <linux/gpio.h>
#include <sys/ioctl.h>

namespace contourd {

bool set_line_inactive(int descriptor) noexcept {
  gpio_v2_line_values second{};
  second.mask = 1;
  if (ioctl(descriptor, GPIO_V2_LINE_SET_VALUES_IOCTL, &second) == 0) return true;
  gpiohandle_data first{};
  return ioctl(descriptor, GPIOHANDLE_SET_LINE_VALUES_IOCTL, &first) == 0;
}

}  // namespace contourd
