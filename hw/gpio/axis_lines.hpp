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

// Returns a sentence about figures in the config that contradict each other, or nullopt if they are
// consistent.
[[nodiscard]] std::optional<std::string> contradiction(const GpioAxisConfig& config);

// The lines of an axis; a line that the config does not name is null.
struct AxisLines {
  std::unique_ptr<OutputLine> step, direction, enable;
  std::array<std::unique_ptr<InputLine>, kAxisInputs> inputs;  // by AxisInput
  std::unique_ptr<InputLine> encoder_a, encoder_b, encoder_index;
};
// Takes all lines that the config names and leaves the motor disabled. Throws HardwareError.
[[nodiscard]] AxisLines take_lines(const GpioAxisConfig& config);

// Reads the present levels of all inputs, and the number of edges that `inputs` has seen.
[[nodiscard]] std::vector<AxisInputState> read_inputs(const GpioAxisConfig& config, const AxisLines& lines,
                                                      const AxisInputs& inputs);

}  // namespace contourd
