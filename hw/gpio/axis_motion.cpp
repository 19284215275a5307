#include "hw/gpio/axis_motion.hpp"

#include <algorithm>
#include <cstdlib>

#include "hw/gpio/plate_position.hpp"
#include "hw/gpio/step_planner.hpp"

namespace contourd {

MotionLimits motion_limits(const GpioAxisConfig& config, MillimetersPerSecond speed) {
  const double per_mm = config.microsteps_per_mm;
  MotionLimits limits{std::min(speed, config.top_speed).count() * per_mm,
                      config.acceleration.count() * per_mm};
  if (config.jerk_mm_s3) limits.jerk = *config.jerk_mm_s3 * per_mm;
  return limits;
}

Duration move_duration(const GpioAxisConfig& config, Nanometers distance, MillimetersPerSecond speed) {
  const Screw screw(config.microsteps_per_mm, config.backlash);
  const Microsteps steps = screw.nearest_step(distance);
  const auto taken = [limits = motion_limits(config, speed)](Microsteps microsteps) {
    return StepPlanner(std::abs(microsteps.count()), limits).duration();
  };
  const Duration rest = config.encoder ? kEncoderRest : Duration{0};
  if (steps >= Microsteps{0} || screw.backlash() == Microsteps{0}) return taken(steps) + rest;
  return taken(steps - screw.backlash()) + taken(screw.backlash()) + rest;
}

}  // namespace contourd
