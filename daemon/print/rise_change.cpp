#include "daemon/print/rise_change.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "core/contract/expects.hpp"
#include "core/mask/exposure_correction.hpp"
#include "hw/rise_curve.hpp"

namespace contourd {
namespace {

constexpr double kPerHour = 3600;  // mm/s to mm/h

// Time for the worker and the event loop, until the plate rises by the new plan.
constexpr double kPlanningSeconds = 0.5;

MillimetersPerSecond fastest_of(const RisePlan& plan) {
  return std::ranges::max_element(plan.points, {}, &RisePoint::speed)->speed;
}

// Returns "with the speed 60 mm/h, the light 50 % and the margin 4".
std::string with_settings(const RiseSettings& settings) {
  return fmt::format("with the speed {:g} mm/h, the light {:g} % and the margin {:g}", settings.speed_mm_h,
                     settings.light_percent, settings.margin);
}

}  // namespace

std::uint8_t white_for(double light_percent, double gamma) {
  expects(light_percent >= 1 && light_percent <= 100, "white pixels give 1 to 100 percent of the light");
  return static_cast<std::uint8_t>(
      std::max(std::lround(255 * power_of_share(light_percent / 100, 1 / gamma)), 1L));
}

double light_of(std::uint8_t white, double gamma) {
  expects(white > 0, "white pixels are lit");
  return power_of_share(white / 255.0, gamma);
}

RiseSettings planned_settings(const RiseBounds& bounds) {
  // One digit, and never slower than planned.
  const double speed_mm_h = std::ceil(bounds.fastest.count() * kPerHour * 10 - 1e-6) / 10;
  return {.speed_mm_h = speed_mm_h, .margin = bounds.margin};
}

RiseBounds bounds_with(const RiseBounds& bounds, double gamma, const RiseSettings& settings) {
  RiseBounds changed = bounds;
  changed.lit.irradiance = bounds.lit.irradiance * light_of(white_for(settings.light_percent, gamma), gamma);
  changed.margin = settings.margin;
  changed.fastest = std::min(bounds.fastest, MillimetersPerSecond{settings.speed_mm_h / kPerHour});
  return changed;
}

void take_change(const ChangedRises& changed, PlannedRises& rises) {
  expects(changed.each.size() <= rises.each.size(), "the rises that are left have changed");
  const std::size_t first = rises.each.size() - changed.each.size();
  for (std::size_t i = 0; i < changed.each.size(); ++i)
    rises.each[first + i].plan = changed.each[i];
  rises.settings = changed.settings;
}

std::variant<ChangedRises, std::string> change_rises(const RisesAhead& ahead, const RiseSettings& settings) {
  expects(ahead.slabs && !ahead.each.empty(), "rises are left, and their slabs are known");
  if (!(settings.speed_mm_h > 0 && settings.light_percent >= 1 && settings.light_percent <= 100 &&
        settings.margin > 1))
    return fmt::format("{} the plate cannot rise: a speed is above 0, a light 1 to 100 %, a margin above 1",
                       with_settings(settings));
  const RiseBounds before = bounds_with(ahead.bounds, ahead.gamma, ahead.settings),
                   bounds = bounds_with(ahead.bounds, ahead.gamma, settings);
  ChangedRises changed{settings, {}};
  if (ahead.height) {
    const double way_mm = fastest_of(ahead.each.front().plan).count() * kPlanningSeconds;
    changed.from = *ahead.height + Nanometers{std::llround(way_mm * 1e6)};
  }
  std::chrono::duration<double> lit = ahead.each.front().lit;
  for (const PlannedRise& rise : ahead.each) {
    const RisePlan& plan = rise.plan;
    const bool is_first = changed.each.empty();
    const RiseChange change{plan, is_first && changed.from ? *changed.from : plan.points.front().height,
                            bounds.lit.irradiance / before.lit.irradiance};
    ChangedRise risen = change_rise(*ahead.slabs, change, bounds);
    if (risen.slowest < bounds.slowest)
      return fmt::format(
          "{} the plate would have to rise at {:.3g} mm/h at {:.2f} mm, and the resin's "
          "continuous/least_speed_mm_h is {:g}",
          with_settings(settings), risen.slowest.count() * kPerHour, in_mm(risen.slowest_at),
          bounds.slowest.count() * kPerHour);
    if (!is_first && rise.lit == Duration{}) lit = {};
    const RisePlan whole = with_overrun(risen.plan);
    lit += duration(is_first && ahead.height ? rest_of(whole, *ahead.height) : whole);
    if (lit > bounds.window)
      return fmt::format(
          "{} the rise from {:.2f} to {:.2f} mm would keep the light on for {:.0f} s in all, and the "
          "window's "
          "oxygen lasts for {:.0f}, the resin's continuous/window_s",
          with_settings(settings), in_mm(plan.points.front().height), in_mm(plan.points.back().height),
          lit.count(), bounds.window.count());
    changed.each.push_back(std::move(risen.plan));
  }
  return changed;
}

}  // namespace contourd
