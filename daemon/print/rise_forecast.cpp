#include "daemon/print/rise_forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string_view>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/print/rise_frames.hpp"
#include "hw/rise_curve.hpp"

namespace contourd {
namespace {

LitResin lit_resin(const ResinProfile& resin, const ContinuousMachine& machine) {
  const CureSettings& cure = resin.cure.value();
  return {cure.curve, MilliwattsPerCm2{machine.irradiance_mw_cm2}, cure.dead_zone};
}

// Returns how far the plate may move within a refresh, so that no mask gets further from it than RiseFrames
// allows. A mask that is less than a mask step old is not replaced, so one that stays for another refresh is
// up to both from the plate, in whole microsteps; and the mask at rest is replaced after 2.5 refreshes. 0 or
// less if microsteps or mask steps are too coarse.
Micrometers most_a_refresh(const ContinuousResin& continuous, const ContinuousMachine& machine) {
  const double farthest_um = in_mm(RiseFrames::kFarthest) * 1000, step_um = machine.microstep.count();
  const double microsteps =
      std::floor(farthest_um / step_um) - std::ceil(continuous.mask_step.count() / step_um) + 1;
  return Micrometers{std::min(microsteps * step_um, farthest_um / 2.5)};
}

MillimetersPerSecond fastest(const ResinProfile& resin, const ContinuousMachine& machine) {
  const ContinuousResin& continuous = resin.continuous.value();
  const Micrometers a_refresh = std::min(continuous.mask_step, most_a_refresh(continuous, machine));
  const MillimetersPerSecond by_masks{to_millimeters(a_refresh).count() * machine.masks_per_s};
  return std::min({by_masks, machine.top_speed.value_or(by_masks), continuous.fastest});
}

// Returns the height from which on the print is not in layers, a whole number of them, at least one.
Nanometers end_of_layers(const ResinProfile& resin, Nanometers layer) {
  const Nanometers layered = resin.continuous.value().layered;
  return layer * std::max<std::int64_t>((layered + layer - Nanometers{1}) / layer, 1);
}

constexpr double kSecondsPerHour = 3600;

// Walks up a print's layers.
struct LayerWalk {
  std::span<const Nanometers> layers;
  std::span<const Duration> times;
  std::size_t layer = 0;  // the next one
  Nanometers height{};    // of its lower side

  // Goes up to a height, and returns the time of the layers on the way.
  Duration to(Nanometers top) {
    Duration time{};
    for (; layer < layers.size() && height < top; ++layer) {
      time += times[layer];
      height += layers[layer];
    }
    return time;
  }
};

// Adds a stretch of a rise to the range before it, or begins a new one.
void add_stretch(const RisePoint& from, const RisePoint& to, bool begins,
                 std::vector<ContinuousRange>& ranges) {
  // Ramps of few micrometres join the range beside them.
  constexpr Nanometers kShort{10'000};
  const bool is_ramp = from.speed != to.speed && to.height - from.height < kShort;
  if (begins || (!is_ramp && ranges.back().slowest.count() > 0 && ranges.back().limit != from.limit))
    ranges.push_back({.bottom = from.height, .top = from.height, .limit = from.limit});
  ContinuousRange& range = ranges.back();
  range.top = to.height;
  range.time += std::chrono::duration_cast<Duration>(duration(from, to));
  if (is_ramp) return;
  const auto [low, high] = std::minmax(from.speed, to.speed);
  if (range.slowest.count() == 0) {
    range.limit = from.limit;
    range.slowest = low.count() > 0 ? low : high;
  } else if (low.count() > 0) {
    range.slowest = std::min(range.slowest, low);
  }
  range.fastest = std::max(range.fastest, high);
}

}  // namespace

ContinuousMachine continuous_machine(const PrinterConfig& printer) {
  return {.irradiance_mw_cm2 = printer.irradiance_mw_cm2,
          .masks_per_s = 1 / std::chrono::duration<double>(printer.simulated.display.frame).count(),
          .microstep = Micrometers{1000 / printer.simulated.axis.microsteps_per_mm},
          .top_speed = printer.top_speed,
          .acceleration = printer.simulated.axis.acceleration,
          .mask_budget = printer.mask_budget,
          .travel = printer.travel};
}

std::string continuous_refusal(const ResinProfile& resin, const ContinuousMachine& machine) {
  std::string missing = missing_for_continuous(resin);
  if (!missing.empty()) return missing;
  const ContinuousResin& continuous = *resin.continuous;
  if (most_a_refresh(continuous, machine).count() <= 0)
    return fmt::format(
        "a plate that moves in microsteps of {:.3g} um cannot rise with a mask for every {:g} um of the "
        "resin {}, because no mask may be more than {:.0f} um from it: lower the resin's "
        "continuous/mask_step_um, "
        "use more microsteps, or print in layers",
        machine.microstep.count(), continuous.mask_step.count(), resin.name,
        in_mm(RiseFrames::kFarthest) * 1000);
  const MillimetersPerSecond cure = cure_speed(lit_resin(resin, machine), continuous.margin);
  const MillimetersPerSecond most = std::min(cure, fastest(resin, machine));
  if (most >= continuous.slowest) return "";
  return fmt::format(
      "the resin {} can rise at most at {:.3g} mm/h, with a margin of {:g}, {:g} mW/cm² and {:.3g} masks/s, "
      "which is less than its continuous/least_speed_mm_h, {:g}: lower the margin or that speed, or print in "
      "layers",
      resin.name, most.count() * kSecondsPerHour, continuous.margin, machine.irradiance_mw_cm2,
      machine.masks_per_s, continuous.slowest.count() * kSecondsPerHour);
}

RiseBounds rise_bounds(const ResinProfile& resin, const ContinuousMachine& machine) {
  expects(continuous_refusal(resin, machine).empty(), "the resin can be printed continuously");
  const ContinuousResin& continuous = *resin.continuous;
  return {.lit = lit_resin(resin, machine),
          .margin = continuous.margin,
          .refill = {.viscosity_pa_s = resin.viscosity_mpa_s.value() / 1000,
                     .pressure_kpa = continuous.refill_pressure_kpa},
          .fastest = fastest(resin, machine),
          .slowest = continuous.slowest,
          .acceleration = machine.acceleration,
          .window = continuous.window,
          .travel = machine.travel};
}

std::vector<RiseSlab> continuous_slabs(ContourEngine& engine, const ContinuousSubject& subject,
                                       const ResinProfile& resin, const ContinuousMachine& machine,
                                       StopCheck& stop) {
  expects(continuous_refusal(resin, machine).empty(), "the resin can be printed continuously");
  const RiseBounds bounds = rise_bounds(resin, machine);
  const Micrometers gap = gel_gap(bounds.lit, bounds.margin);
  const SlabSettings settings{.display = subject.display,
                              .top = subject.top,
                              .thickness = slab_thickness(subject.top, subject.layer, gap),
                              .growth = resin.compensation.growth,
                              .mask_budget = machine.mask_budget};
  return sweep_slabs(engine, settings, stop);
}

std::vector<RisePlan> rises_through(std::span<const RiseSlab> slabs, Nanometers layer,
                                    const ResinProfile& resin, const ContinuousMachine& machine) {
  expects(layer > Nanometers{}, "a layer has a thickness");
  return plan_rises(slabs, end_of_layers(resin, layer), rise_bounds(resin, machine));
}

std::vector<PlannedRise> rises_between(std::vector<RisePlan> rises, std::span<const Nanometers> layers,
                                       std::span<const Duration> layer_times, const ContinuousResin& resin) {
  expects(layers.size() == layer_times.size(), "each layer has a time");
  std::vector<PlannedRise> planned;
  LayerWalk walk{layers, layer_times};
  Duration lit{};  // by rises, since the window had all its oxygen
  for (RisePlan& rise : rises) {
    const Duration layered = walk.to(rise.points.front().height);
    expects(walk.height == rise.points.front().height, "a rise begins on top of a layer");
    PlannedRise next{.plan = std::move(rise), .first_layer = static_cast<std::int32_t>(walk.layer)};
    const auto time = std::chrono::duration_cast<Duration>(duration(with_overrun(next.plan)));
    if (layered >= resin.recovery) lit = Duration{};
    if (lit > Duration{} && lit + time > resin.window) {
      next.rest = resin.recovery - layered;
      lit = Duration{};
    }
    next.lit = lit;
    lit += time;
    (void)walk.to(next.plan.points.back().height);
    planned.push_back(std::move(next));
  }
  return planned;
}

std::string why_no_rise(const ContinuousSubject& subject, const ResinProfile& resin) {
  const Nanometers layers = end_of_layers(resin, subject.layer);
  if (subject.top - layers < kLowestRise)
    return fmt::format(
        "the print is layered, not continuous: it is {:.2f} mm high, and above its first layers, {:.2f} mm, "
        "the plate would have to rise {:.0f} mm",
        in_mm(subject.top), in_mm(layers), in_mm(kLowestRise));
  return fmt::format(
      "the print is layered, not continuous: nowhere can the plate rise {:.0f} mm without a stop at {:.3g} "
      "mm/h, the resin's continuous/least_speed_mm_h, or faster, because the sections are too wide for the "
      "resin to flow in, or the window's oxygen lasts for too short a rise; turn the model, or lower that "
      "speed",
      in_mm(kLowestRise), resin.continuous.value().slowest.count() * kSecondsPerHour);
}

std::vector<ContinuousRange> ranges_of(const PrintPlan& plan, std::span<const Duration> times) {
  expects(plan.expected_layers.size() == times.size(), "each layer has a time");
  std::vector<ContinuousRange> ranges;
  LayerWalk walk{plan.expected_layers, times};
  const auto add_layers = [&](Nanometers to) {
    ContinuousRange range{.bottom = walk.height};
    range.time = walk.to(to);
    range.top = walk.height;
    if (range.bottom < range.top) ranges.push_back(range);
  };
  for (const PlannedRise& rise : plan.rises ? plan.rises->each : std::vector<PlannedRise>()) {
    const std::vector<RisePoint>& points = rise.plan.points;
    add_layers(points.front().height);
    if (!ranges.empty()) ranges.back().rest = rise.rest;
    const std::size_t first = ranges.size();
    for (std::size_t i = 1; i < points.size(); ++i)
      add_stretch(points[i - 1], points[i], i == 1, ranges);
    Duration moves = walk.to(points.back().height) - rise.rest;
    for (std::size_t i = first; i < ranges.size(); ++i)
      moves -= ranges[i].time;
    ranges[first].time += moves;
  }
  add_layers(std::accumulate(plan.expected_layers.begin(), plan.expected_layers.end(), Nanometers{}));
  return ranges;
}

Duration ContinuousForecast::time() const {
  Duration time{};
  for (const ContinuousRange& range : ranges)
    time += range.time + range.rest;
  return time;
}

ChangedForecast changed_forecast(const RisesAhead& ahead, const ChangedRises& changed) {
  expects(!changed.each.empty() && changed.each.size() == ahead.each.size(), "all rises have changed");
  ChangedForecast forecast{changed.each.front().points.front().height,
                           changed.settings,
                           {bounds_with(ahead.bounds, ahead.gamma, changed.settings)}};
  std::vector<ContinuousRange>& ranges = forecast.plan.ranges;
  for (std::size_t i = 0; i < changed.each.size(); ++i) {
    RisePlan plan = changed.each[i];
    if (i == 0 && ahead.height) {
      forecast.from = *ahead.height;
      plan = rest_of(plan, *ahead.height);
    } else if (!ranges.empty()) {
      ranges.back().rest = ahead.each[i].rest;
    }
    for (std::size_t point = 1; point < plan.points.size(); ++point)
      add_stretch(plan.points[point - 1], plan.points[point], point == 1, ranges);
  }
  return forecast;
}

void end_at(Nanometers height, ContinuousForecast& plan) {
  std::erase_if(plan.ranges, [&](const ContinuousRange& range) { return range.bottom >= height; });
  if (plan.ranges.empty() || plan.ranges.back().top <= height) return;
  ContinuousRange& last = plan.ranges.back();
  const double part = in_mm(height - last.bottom) / in_mm(last.top - last.bottom);
  last.time = std::chrono::duration_cast<Duration>(last.time * part);
  last.top = height;
  last.rest = {};
}

std::string layered_parts_sentence(const ContinuousForecast& forecast, Nanometers first_layers) {
  constexpr Nanometers kWorthTelling{1'000'000};
  Nanometers layered{};
  const ContinuousRange* widest = nullptr;
  for (const ContinuousRange& range : forecast.ranges) {
    if (range.limit) continue;
    layered += range.top - range.bottom;
    if (widest == nullptr || range.top - range.bottom > widest->top - widest->bottom) widest = &range;
  }
  if (layered - first_layers <= kWorthTelling) return "";
  return fmt::format(
      "{:.2f} of {:.2f} mm are printed layer by layer, such as from {:.2f} to {:.2f} mm, because the plate "
      "cannot rise there without a stop",
      in_mm(layered), in_mm(forecast.ranges.back().top), in_mm(widest->bottom), in_mm(widest->top));
}

}  // namespace contourd
