// The configuration of a real machine. Value types.
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
  // At least one of these two. The light line is required if the projector's table cannot switch the light.
  std::optional<SerialProjectorConfig> projector;
  std::optional<GpioLineConfig> light;
  Duration warm_up{};  // minimum for the lamp
};

// The part of a machine's configuration that turns its light off. Only the table's commands for that are
// used.
struct LightConfig {
  std::optional<GpioLineConfig> line;
  std::optional<SerialProjectorConfig> projector;
  // True if the last contourd ended in order, with the light confirmed off: a projector's answer that it is
  // off can then be believed.
  bool left_dark = false;
};

}  // namespace contourd
