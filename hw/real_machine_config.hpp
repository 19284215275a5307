// The configuration of a real machine (value types), and the functions that open its devices.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "hw/clock.hpp"
#include "hw/drm/drm_display_config.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/serial/projector_table.hpp"

namespace contourd {

class DescriptorWatcher;
class MaskDisplay;
class Projector;
class ZAxis;

struct SerialProjectorConfig {
  std::string port;  // "/dev/ttyUSB0"
  ProjectorTable table;
  std::optional<std::int32_t> brightness;  // within the table's limits
  [[nodiscard]] Duration warm_up() const { return table.warm_up; }
};

// Any projector's configuration. Each kind has a struct with a function warm_up(), and an open_device().
using ProjectorConfig = std::variant<SerialProjectorConfig>;

// Returns the time from power on to light that can be used, at least.
[[nodiscard]] inline Duration warm_up_of(const ProjectorConfig& config) {
  return std::visit([](const auto& kind) { return kind.warm_up(); }, config);
}

struct RealMachineConfig {
  GpioAxisConfig axis;
  DrmDisplayConfig display;
  // At least one of these two. The light line is required if the projector cannot switch its light.
  std::optional<ProjectorConfig> projector;
  std::optional<GpioLineConfig> light;
  Duration warm_up{};  // the lamp's; the projector's own if there is one
};

// The part of a machine's configuration that turns its light off.
struct LightConfig {
  std::optional<GpioLineConfig> line;
  std::optional<ProjectorConfig> projector;  // with the commands for that; nullopt if it has none
  // True if the last contourd ended in order, with the light confirmed off: a projector's answer that it is
  // off can then be believed.
  bool left_dark = false;
};

// Open a device, each kind in the source of its class; a projector is sent nothing. They throw HardwareError
// if the device cannot be used. The clock and the watcher must outlive the device.
[[nodiscard]] std::unique_ptr<ZAxis> open_device(const GpioAxisConfig& config, Clock& clock,
                                                 DescriptorWatcher& watcher);
[[nodiscard]] std::unique_ptr<MaskDisplay> open_device(const DrmDisplayConfig& config, Clock& clock,
                                                       DescriptorWatcher& watcher);
[[nodiscard]] std::unique_ptr<Projector> open_device(const SerialProjectorConfig& config, Clock& clock,
                                                     DescriptorWatcher& watcher);

// Opens a device of any kind.
template <typename... Kinds>
[[nodiscard]] auto open_device(const std::variant<Kinds...>& config, Clock& clock,
                               DescriptorWatcher& watcher) {
  return std::visit([&](const auto& kind) { return open_device(kind, clock, watcher); }, config);
}

}  // namespace contourd
