#include "daemon/print/layer_durations.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <span>

#include "core/contract/expects.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {
namespace {

// Returns the duration of the way from a lift down to the height from which the plate rises, and of the wait
// there.
template <typename Move>
Duration approach_duration(const PrintPlan& plan, std::int32_t layer, const Move& move) {
  return lowering_duration(plan.motion, Nanometers{}, move) + expected_settling(plan, layer);
}

// Returns the function that computes the duration of a move on this printer.
auto moves_of(const PrinterConfig& printer) {
  return [&printer](Nanometers distance, MillimetersPerSecond speed) {
    if (printer.real) return move_duration(printer.real->axis, distance, speed);
    return MotionProfile(distance, speed, printer.simulated.axis.acceleration).duration();
  };
}

// Returns the duration of the expected layers of a part of the print, of a rise or of one layer, on an axis
// described by `move(distance, speed)`. The first layer of a rise has the rest and the moves before it, the
// last one the lift after it.
template <typename Move>
std::vector<Duration> durations_of(const PrintPlan& plan, const Move& move) {
  std::vector<Duration> durations;
  const std::span<const PlannedRise> rises =
      plan.rises ? std::span<const PlannedRise>(plan.rises->each) : std::span<const PlannedRise>();
  auto rise = rises.begin();
  Nanometers top{};
  for (std::size_t i = 0; i < plan.expected_layers.size(); ++i) {
    const auto layer = static_cast<std::int32_t>(i);
    const Nanometers bottom = top;
    top += plan.expected_layers[i];
    if (rise != rises.end() && bottom >= rise->plan.points.back().height) ++rise;
    if (rise == rises.end() || layer < rise->first_layer) {
      durations.push_back(layer_duration(plan, layer, move));
      continue;
    }
    Duration time = std::chrono::duration_cast<Duration>(duration(rise->plan, bottom, top));
    if (layer == rise->first_layer) time += rise->rest + approach_duration(plan, layer, move);
    if (top >= rise->plan.points.back().height) time += lift_duration(plan.motion, move);
    durations.push_back(time);
  }
  return durations;
}

}  // namespace

std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer) {
  return durations_of(plan, moves_of(printer));
}

std::vector<Duration> layer_durations(const PrintPlan& plan, const ZAxis& axis) {
  return durations_of(plan, contourd::moves_of(axis));
}

std::vector<Duration> durations_to_end(const PrintPlan& plan, const ZAxis& axis) {
  std::vector<Duration> left = layer_durations(plan, axis);
  const Nanometers top =
      std::accumulate(plan.expected_layers.begin(), plan.expected_layers.end(), Nanometers{});
  const Nanometers to_park = std::max(axis.travel() - top - plan.motion.whole_lift(), Nanometers{});
  left.push_back(axis.move_duration(to_park, plan.travel_speed));
  for (std::size_t i = left.size() - 1; i-- > 0;)
    left[i] += left[i + 1];
  return left;
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
