// What a real machine is made of, as its owner describes it. Value types.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hw/drm/drm_display_config.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

struct SerialProjectorConfig {
  std::string port;  // "/dev/ttyUSB0"
  ProjectorTable table;
  std::optional<std::int32_t> brightness;  // within the table's limits
};

struct RealMachineConfig {
  GpioAxisConfig axis;
  DrmDisplayConfig display;
  // One of these at least; the light is a line wherever the projector's table cannot switch it.
  std::optional<SerialProjectorConfig> projector;
  std::optional<GpioLineConfig> light;
  Duration warm_up{};  // of the lamp, at least
};

// What of a machine turns its light off. Of the table, only that is looked at.
struct LightConfig {
  std::optional<GpioLineConfig> line;
  std::optional<SerialProjectorConfig> projector;
  // A contourd that ended in order had the light confirmed off: a projector that says that it is off is so.
  bool left_dark = false;
};

}  // namespace contourd
