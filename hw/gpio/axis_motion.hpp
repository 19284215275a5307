// How a stepped axis moves, by its configuration alone: for the axis, and for estimates without it. Pure
// functions.
#pragma once

#include <chrono>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"
#include "hw/gpio/gpio_axis_config.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {

// The encoder is looked at this long after the motor has come to rest.
inline constexpr Duration kEncoderRest{std::chrono::milliseconds{20}};

// In microsteps, of a move that is asked for at that speed.
[[nodiscard]] MotionLimits motion_limits(const GpioAxisConfig& config, MillimetersPerSecond speed);

// From the first step until the plate is known to be there: the way back for the backlash included.
[[nodiscard]] Duration move_duration(const GpioAxisConfig& config, Nanometers distance,
                                     MillimetersPerSecond speed);

}  // namespace contourd
