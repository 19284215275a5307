#include "daemon/control/setting_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <variant>

#include "core/continuous/rise_laws.hpp"
#include "daemon/print/rise_change.hpp"

namespace contourd {
namespace {

// The bounds in config/resin.schema.json.
constexpr Limits<double> kLiftMm{0.1, 100}, kSpeedMmS{0.01, 50}, kRestMs{0, 60'000};
// A lift is shorter than the travel, by 1 um at least.
constexpr double kLeastRoom = 0.001;

template <typename Quantity>
void narrow(Limits<double>& bounds, const std::optional<Limits<Quantity>>& limits) {
  if (!limits) return;
  bounds = {std::max(bounds.least, figure_of(limits->least)), std::min(bounds.most, figure_of(limits->most))};
}

Limits<double> exposure_bounds(const JobSummary& job, std::int32_t layer) {
  const ResinProfile& resin = job.resin;
  Limits<double> percent{1, 1000};
  const auto keep = [&](Duration exposure, const std::optional<Limits<Duration>>& limits) {
    Limits<double> bounds{figure_of(kShortestExposure), figure_of(kLongestExposure)};
    narrow(bounds, limits);
    percent.least = std::max(percent.least, 100 * bounds.least / figure_of(exposure));
    percent.most = std::min(percent.most, 100 * bounds.most / figure_of(exposure));
  };
  const std::int32_t normal = resin.bottom_layers + resin.fade_layers;
  for (const Nanometers thickness : {job.layers.thinnest, job.layers.thickest}) {
    const auto exposure = [&](std::int32_t number) {
      return exposure_time(resin, thickness, number, job.irradiance_mw_cm2);
    };
    keep(exposure(std::max(layer, normal)), resin.limits.exposure);
    if (layer < normal) keep(exposure(layer), resin.limits.bottom_exposure);
  }
  if (const auto* const fixed = std::get_if<FixedExposure>(&resin.exposure))
    for (const ExposureStep& step : fixed->steps)
      keep(step.exposure, resin.limits.exposure);
  // Rounded inwards, so that each bound in a message is itself allowed.
  return {std::min(100.0, std::ceil(percent.least * 10) / 10),
          std::max(100.0, std::floor(percent.most * 10) / 10)};
}

// The settings of rises: those with which the plate can rise at the slowest speed, if resin flows in fast
// enough. The margin has the bounds of config/resin.schema.json, too.
Limits<double> rise_setting_bounds(std::string_view setting, const RiseBounds& rise) {
  constexpr double kPerHour = 3600;
  constexpr Limits<double> kMargin{1.1, 100};
  const double least_mm_h = rise.slowest.count() * kPerHour;
  const double times_margin_mm_h = cure_speed(rise.lit, rise.margin).count() * rise.margin * kPerHour;
  if (setting == "speed") return {least_mm_h, planned_settings(rise).speed_mm_h};
  const double most_margin = std::floor(times_margin_mm_h / least_mm_h * 100) / 100;
  if (setting == "margin") return {kMargin.least, std::min(kMargin.most, most_margin)};
  return {std::max(1.0, std::ceil(100 * least_mm_h * rise.margin / times_margin_mm_h)), 100};
}

}  // namespace

Limits<double> setting_bounds(std::string_view setting, const JobSummary& job, const ResinMachine& machine,
                              std::int32_t layer) {
  if (setting == "exposure") return exposure_bounds(job, layer);
  if (is_of_rises(setting)) return rise_setting_bounds(setting, job.continuous.value().bounds);
  const LayerMotion& motion = job.resin.motion;
  Limits<double> bounds = kSpeedMmS;
  if (setting == "lift") {
    bounds = {std::max(kLiftMm.least, figure_of(motion.slow_retract) - figure_of(motion.second_lift)),
              kLiftMm.most};
    if (machine.travel)
      bounds.most =
          std::min(bounds.most, figure_of(*machine.travel) - figure_of(motion.second_lift) - kLeastRoom);
    narrow(bounds, job.resin.limits.lift);
  } else if (setting == "rest") {
    bounds = kRestMs;
    narrow(bounds, job.resin.limits.rest);
  } else if (machine.top_speed) {
    bounds.most = std::min(bounds.most, machine.top_speed->count());
  }
  return bounds;
}

}  // namespace contourd
