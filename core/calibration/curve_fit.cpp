#include "core/calibration/curve_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "core/calibration/refuse.hpp"

namespace contourd {
namespace {

constexpr std::size_t kFewestWindows = 5;
constexpr double kLeastSpan = 4;  // of the doses; less leaves Dp too uncertain
constexpr double kLeastGreySpan = 255.0 / 180.0;
constexpr double kMostUncertain = 0.1;  // of a slope, as a share of it

void check_count(std::size_t count) {
  if (count < kFewestWindows)
    refuse("%zu windows do not determine a curve: measure at least %zu, better eight", count, kFewestWindows);
}

// Returns the line of thickness over the light's logarithm.
LineFit fit_thicknesses(const std::vector<MeasuredPoint>& points, const char* light) {
  const LineFit line = fit_line(points);
  if (!(line.slope.value > 0))
    refuse(
        "the thickness does not grow with the %s: %.3g um less for each e-fold of light; check which value "
        "belongs to which window",
        light, -line.slope.value);
  if (!(line.slope.uncertainty <= kMostUncertain * line.slope.value))
    refuse(
        "the thicknesses scatter by %.3g um about the best curve, so that its slope is %.4g um with an "
        "uncertainty of %.3g um, more than a tenth: measure each window several times and give the mean, or "
        "leave out windows that were torn or not quite cured",
        line.scatter, line.slope.value, line.slope.uncertainty);
  return line;
}

double span_of(const std::vector<MeasuredPoint>& points) {
  const auto [least, most] = std::ranges::minmax(points, {}, &MeasuredPoint::x);
  return std::exp(most.x - least.x);
}

}  // namespace

Micrometers CurveFit::thickness_of(MillijoulesPerCm2 dose) const {
  return Micrometers{penetration_depth_um.value * std::log(dose.count() / critical_dose_mj_cm2.value)};
}

Micrometers GammaFit::thickness_of(std::uint8_t grey) const {
  return Micrometers{line.at(std::log(grey / 255.0))};
}

CurveFit fit_working_curve(std::span<const CuredWindow> windows) {
  check_count(windows.size());
  std::vector<MeasuredPoint> points;
  for (const auto& [dose, thickness] : windows) {
    if (!(dose.count() > 0) || !(thickness.count() > 0))
      refuse(
          "a window of %.4g um at %.4g mJ/cm2: both must be more than 0; leave out windows without cured "
          "resin",
          thickness.count(), dose.count());
    points.push_back({std::log(dose.count()), thickness.count()});
  }
  if (const double span = span_of(points); !(span >= kLeastSpan))
    refuse("the doses span a factor of %.3g: they must span at least %g, better 16", span, kLeastSpan);
  const LineFit line = fit_thicknesses(points, "dose");
  const double depth = line.slope.value;
  // ln Ec = mean ln E - mean thickness / Dp, of two independent estimates.
  const double log_critical = line.mean_x - line.mean_y.value / depth;
  const double by_slope = line.mean_y.value * line.slope.uncertainty / (depth * depth);
  const double log_uncertainty = std::hypot(line.mean_y.uncertainty / depth, by_slope);
  return {.penetration_depth_um = line.slope,
          .critical_dose_mj_cm2 = {std::exp(log_critical), std::exp(log_critical) * log_uncertainty},
          .correlation = log_uncertainty > 0 ? by_slope / log_uncertainty : 0,
          .line = line};
}

GammaFit fit_gamma(std::span<const GreyWindow> windows, Estimate penetration_depth_um) {
  check_count(windows.size());
  std::vector<MeasuredPoint> points;
  for (const auto& [grey, thickness] : windows) {
    if (grey == 0 || !(thickness.count() > 0))
      refuse(
          "a window of %.4g um at grey %d: both must be more than 0; leave out windows without cured resin",
          thickness.count(), static_cast<int>(grey));
    points.push_back({std::log(grey / 255.0), thickness.count()});
  }
  if (const double span = span_of(points); !(span >= kLeastGreySpan))
    refuse("the grey values span a factor of %.3g: they must span at least %.3g, from 255 to 180", span,
           kLeastGreySpan);
  const LineFit line = fit_thicknesses(points, "grey value");
  const double gamma = line.slope.value / penetration_depth_um.value;
  return {.gamma = {gamma, gamma * std::hypot(line.slope.uncertainty / line.slope.value,
                                              penetration_depth_um.uncertainty / penetration_depth_um.value)},
          .line = line};
}

}  // namespace contourd
