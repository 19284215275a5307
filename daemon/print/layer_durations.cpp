#include "daemon/print/layer_durations.hpp"

#include "hw/gpio/axis_motion.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {

std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer) {
  const auto move = [&printer](Nanometers distance, MillimetersPerSecond speed) {
    if (printer.real) return move_duration(printer.real->axis, distance, speed);
    return MotionProfile(distance, speed, printer.simulated.axis.acceleration).duration();
  };
  std::vector<Duration> durations;
  for (std::size_t layer = 0; layer < plan.expected_layers.size(); ++layer)
    durations.push_back(layer_duration(plan, static_cast<std::int32_t>(layer), move));
  return durations;
}

}  // namespace contourd
