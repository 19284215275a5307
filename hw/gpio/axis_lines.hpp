// The lines that an axis' configuration names.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hw/gpio/axis_inputs.hpp"
#include "hw/gpio/digital_line.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/z_axis.hpp"

namespace contourd {

// What is wrong with the figures together, as a sentence; nothing when they fit.
[[nodiscard]] std::optional<std::string> contradiction(const GpioAxisConfig& config);

// The lines of an axis, those that its config names.
struct AxisLines {
  std::unique_ptr<OutputLine> step, direction, enable;
  std::array<std::unique_ptr<InputLine>, kAxisInputs> inputs;  // by AxisInput
  std::unique_ptr<InputLine> encoder_a, encoder_b, encoder_index;
};
// Takes them all, the motor disabled. Throws HardwareError.
[[nodiscard]] AxisLines take_lines(const GpioAxisConfig& config);

// Those that are inputs, read now, with the edges that `inputs` has seen.
[[nodiscard]] std::vector<AxisInputState> read_inputs(const GpioAxisConfig& config, const AxisLines& lines,
                                                      const AxisInputs& inputs);

}  // namespace contourd
