#include "daemon/print/layer_durations.hpp"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <span>

#include "core/contract/expects.hpp"
#include "daemon/print/rise_progress.hpp"
#include "hw/gpio/axis_motion.hpp"
#include "hw/motion_curve.hpp"

namespace contourd {
namespace {

// A layer's place in the print.
struct LayerSlice {
  std::int32_t layer;
  Nanometers bottom, top;
};

// Returns the function that computes the duration of a move on this printer.
auto moves_of(const PrinterConfig& printer) {
  return [&printer](Nanometers distance, MillimetersPerSecond speed) {
    if (printer.real) return move_duration(printer.real->axis, distance, speed);
    return MotionProfile(distance, speed, printer.simulated.axis.acceleration).duration();
  };
}

// Returns the time of an expected layer on an axis described by `move(distance, speed)`.
template <typename Move>
TimeByCause layer_time(const PrintPlan& plan, std::int32_t layer, const Move& move) {
  const Nanometers thickness = plan.expected_layers[static_cast<std::size_t>(layer)];
  TimeByCause time;
  time[TimeCause::Lowering] = lowering_duration(plan.motion, thickness, move);
  time[TimeCause::Settling] = expected_settling(plan, layer);
  time[TimeCause::Light] = exposure_of(plan, layer, thickness);
  time[TimeCause::Resting] = plan.motion.after_light();
  time[TimeCause::Lifting] = lift_duration(plan.motion, move);
  return time;
}

// Returns the time of a slice of a rise, between two heights. The first slice has the rest and the moves
// before the rise, the last one the lift after it. Resin of a slice gels while the plate is above it.
template <typename Move>
TimeByCause slice_time(const PrintPlan& plan, std::size_t at, LayerSlice slice, const Move& move) {
  const PlannedRise& rise = plan.rises->each[at];
  const RisePlan way = way_of(rise.plan, end_beneath(plan.rises->each, at));
  const Nanometers low = slice.layer == rise.first_layer ? Nanometers{} : slice.bottom + rise.plan.overrun;
  TimeByCause time;
  time[TimeCause::Light] =
      std::chrono::duration_cast<Duration>(duration(way, low, slice.top + rise.plan.overrun));
  if (slice.layer == rise.first_layer) {
    time[TimeCause::Recovering] = rise.rest;
    time[TimeCause::Lowering] = lowering_duration(plan.motion, Nanometers{}, move);
    time[TimeCause::Settling] = expected_settling(plan, slice.layer);
  }
  if (slice.top >= rise.plan.points.back().height)
    time[TimeCause::Lifting] = lift_duration(plan.motion, move);
  return time;
}

// Calls `take(layer, time)` for each expected layer of a part of the print, of a rise or not.
template <typename Move, typename Take>
void for_each_layer(const PrintPlan& plan, const Move& move, const Take& take) {
  const std::span<const PlannedRise> rises =
      plan.rises ? std::span<const PlannedRise>(plan.rises->each) : std::span<const PlannedRise>();
  std::size_t at = 0;  // index of the rise
  Nanometers top{};
  for (std::size_t i = 0; i < plan.expected_layers.size(); ++i) {
    const auto layer = static_cast<std::int32_t>(i);
    const Nanometers bottom = top;
    top += plan.expected_layers[i];
    if (at < rises.size() && bottom >= rises[at].plan.points.back().height) ++at;
    const bool rises_here = at < rises.size() && layer >= rises[at].first_layer;
    take(layer,
         rises_here ? slice_time(plan, at, {layer, bottom, top}, move) : layer_time(plan, layer, move));
  }
}

template <typename Move>
std::vector<Duration> durations_of(const PrintPlan& plan, const Move& move) {
  std::vector<Duration> durations;
  for_each_layer(plan, move,
                 [&](std::int32_t, const TimeByCause& time) { durations.push_back(time.total()); });
  return durations;
}

void add(const TimeByCause& more, TimeByCause& sum) {
  for (std::size_t cause = 0; cause < kTimeCauses; ++cause)
    sum.each[cause] += more.each[cause];
}

Nanometers sum_of(std::span<const Nanometers> layers) {
  return std::accumulate(layers.begin(), layers.end(), Nanometers{});
}

// Returns the number, among these, of the first duration that is the median.
std::size_t median_of(const std::vector<Duration>& durations) {
  std::vector<Duration> sorted = durations;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
  std::ranges::nth_element(sorted, middle);
  return static_cast<std::size_t>(std::ranges::find(durations, *middle) - durations.begin());
}

// Returns the time of the layers from one on, as a whole and of two of them.
template <typename Move>
PrintForecast forecast_of_layers(const PrintPlan& plan, std::int32_t first, const Move& move) {
  PrintForecast forecast;
  std::vector<Duration> durations;
  for_each_layer(plan, move, [&](std::int32_t layer, const TimeByCause& time) {
    if (layer < first) return;
    durations.push_back(time.total());
    add(time, forecast.time);
    if (layer == first || time.total() > forecast.longest.time.total()) forecast.longest = {layer, time};
  });
  const std::int32_t typical = first + static_cast<std::int32_t>(median_of(durations));
  for_each_layer(plan, move, [&](std::int32_t layer, const TimeByCause& time) {
    if (layer == typical) forecast.typical = {layer, time};
  });
  return forecast;
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
  const Nanometers to_park =
      std::max(axis.travel() - sum_of(plan.expected_layers) - plan.motion.whole_lift(), Nanometers{});
  left.push_back(axis.move_duration(to_park, plan.travel_speed));
  for (std::size_t i = left.size() - 1; i-- > 0;)
    left[i] += left[i + 1];
  return left;
}

PrintForecast forecast_of(const PrintPlan& plan, const PrinterConfig& printer) {
  expects(!plan.expected_layers.empty(), "a print has a layer");
  const ResumePoint from = plan.resume.value_or(ResumePoint{});
  const std::int32_t first = std::min(from.layer, static_cast<std::int32_t>(plan.expected_layers.size()) - 1);
  const auto move = moves_of(printer);
  PrintForecast forecast = forecast_of_layers(plan, first, move);
  TimeByCause& time = forecast.time;
  const Nanometers thickness = plan.expected_layers[static_cast<std::size_t>(first)];
  const Nanometers to_park =
      std::max(printer.travel - sum_of(plan.expected_layers) - plan.motion.whole_lift(), Nanometers{});
  time[TimeCause::WarmingUp] += plan.warm_up;
  time[TimeCause::Homing] += homing_duration(plan, printer.travel, move);
  // For its first layer, the plate comes from the height after homing, not from a lift.
  time[TimeCause::Lowering] +=
      lowering_duration(plan.motion, plan.home_height - from.bottom - thickness, plan.travel_speed, move) -
      lowering_duration(plan.motion, thickness, move);
  time[TimeCause::Parking] += move(to_park, plan.travel_speed);
  return forecast;
}

}  // namespace contourd
