#include "daemon/print/layer_durations.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {
namespace {

// Returns the function that computes the duration of a move on this printer.
auto moves_of(const PrinterConfig& printer) {
  return [&printer](Nanometers distance, MillimetersPerSecond speed) {
    if (printer.real) return move_duration(printer.real->axis, distance, speed);
    return MotionProfile(distance, speed, printer.simulated.axis.acceleration).duration();
  };
}

}  // namespace

std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer) {
  std::vector<Duration> durations;
  Nanometers top{};
  for (std::size_t layer = 0; layer < plan.expected_layers.size(); ++layer) {
    const Nanometers bottom = top;
    top += plan.expected_layers[layer];
    const auto number = static_cast<std::int32_t>(layer);
    durations.push_back(plan.rise && number >= plan.rise->first_layers
                            ? std::chrono::duration_cast<Duration>(duration(plan.rise->plan, bottom, top))
                            : layer_duration(plan, number, moves_of(printer)));
  }
  return durations;
}

Duration print_duration(const PrintPlan& plan, const PrinterConfig& printer) {
  expects(!plan.expected_layers.empty(), "a print has a layer");
  const auto move = moves_of(printer);
  const std::vector<Duration> layers = layer_durations(plan, printer);
  const Nanometers top =
      std::accumulate(plan.expected_layers.begin(), plan.expected_layers.end(), Nanometers{});
  const Nanometers to_park = std::max(printer.travel - top - plan.motion.whole_lift(), Nanometers{});
  // For its first layer, the plate comes from the height after homing, not from a lift.
  const Duration approach = lowering_duration(plan.motion, plan.home_height - plan.expected_layers.front(),
                                              plan.travel_speed, move) -
                            lowering_duration(plan.motion, plan.expected_layers.front(), move);
  return plan.warm_up + homing_duration(plan, printer.travel, move) + approach +
         std::accumulate(layers.begin(), layers.end(), Duration{0}) + move(to_park, plan.travel_speed);
}

}  // namespace contourd
