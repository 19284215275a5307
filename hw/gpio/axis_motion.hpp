// Motion limits and durations of a stepped axis, computed from its config alone: used by the axis, and for
// estimates without it. Pure functions.
#pragma once

#include <chrono>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {

// The wait between the motor's last step and the check of the encoder.
inline constexpr Duration kEncoderRest{std::chrono::milliseconds{20}};

// Returns the limits, in microsteps, of a move that is requested at that speed.
[[nodiscard]] MotionLimits motion_limits(const GpioAxisConfig& config, MillimetersPerSecond speed);

// Returns the motor's pull-in speed: that of homing's second pass, from which the motor stops dead and must
// not lose steps.
[[nodiscard]] inline MillimetersPerSecond pull_in_speed(const GpioAxisConfig& config) {
  return config.homing_speed / 2;
}

// Returns the time from the first step until the plate is known to be there, including the way back for the
// backlash.
[[nodiscard]] Duration move_duration(const GpioAxisConfig& config, Nanometers distance,
                                     MillimetersPerSecond speed);

}  // namespace contourd
