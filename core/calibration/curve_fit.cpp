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
constexpr double kSpanRounding = 1e-9;  // a span that is just reached counts
// Curves of resins: 36 to 1110 um and 0.7 to 24 mJ/cm2 were published, and one resin's Ec differs 70-fold
// between laboratories.
constexpr double kLeastDepthUm = 15, kMostDepthUm = 2000;
constexpr double kLeastCritical = 0.05, kMostCritical = 500;  // mJ/cm2
constexpr double kMostUncertain = 0.1;                        // of a slope, as a share of it

void check_count(std::size_t count) {
  if (count < kFewestWindows)
    refuse("%zu %s not determine a curve: measure at least %zu, better eight", count,
           count == 1 ? "window does" : "windows do", kFewestWindows);
}

void check_thickness(Micrometers thickness) {
  if (thickness.count() <= kThickestUm) return;
  refuse("a window of %.4g um: cured resin is at most %g um thick; type thicknesses in um", thickness.count(),
         kThickestUm);
}

// Returns the line of thickness over the light's logarithm.
LineFit fit_thicknesses(const std::vector<MeasuredPoint>& points, Micrometers reading, const char* light) {
  const LineFit line = fit_line(points, reading.count());
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

// Refuses a curve that no resin has.
void check_plausible(std::span<const CuredWindow> windows, double depth_um, double critical) {
  if (depth_um >= kLeastDepthUm && depth_um <= kMostDepthUm && critical >= kLeastCritical &&
      critical <= kMostCritical)
    return;
  const auto [thinnest, thickest] = std::ranges::minmax(windows, {}, &CuredWindow::thickness);
  const auto [darkest, brightest] = std::ranges::minmax(windows, {}, &CuredWindow::dose);
  refuse(
      "%.4g to %.4g um at %.4g to %.4g mJ/cm2 give a penetration depth of %.3g um and a critical dose of "
      "%.3g mJ/cm2, but resins have %g to %g um and %g to %g mJ/cm2: type thicknesses in um (0.104 mm as "
      "104) and doses in mJ/cm2, and check projector.irradiance_mw_cm2",
      thinnest.thickness.count(), thickest.thickness.count(), darkest.dose.count(), brightest.dose.count(),
      depth_um, critical, kLeastDepthUm, kMostDepthUm, kLeastCritical, kMostCritical);
}

}  // namespace

Micrometers CurveFit::thickness_of(MillijoulesPerCm2 dose) const {
  return Micrometers{penetration_depth_um.value * std::log(dose.count() / critical_dose_mj_cm2.value)};
}

Micrometers GammaFit::thickness_of(std::uint8_t grey) const {
  return Micrometers{line.at(std::log(grey / 255.0))};
}

CurveFit fit_working_curve(std::span<const CuredWindow> windows, Micrometers reading) {
  check_count(windows.size());
  std::vector<MeasuredPoint> points;
  for (const auto& [dose, thickness] : windows) {
    if (!(dose.count() > 0) || !(thickness.count() > 0))
      refuse(
          "a window of %.4g um at %.4g mJ/cm2: both must be more than 0; leave out windows without cured "
          "resin",
          thickness.count(), dose.count());
    check_thickness(thickness);
    points.push_back({std::log(dose.count()), thickness.count()});
  }
  const auto [least, most] = std::ranges::minmax(windows, {}, &CuredWindow::dose);
  if (const double span = most.dose / least.dose; !(span >= kLeastSpan - kSpanRounding))
    refuse("the doses span a factor of %.4g: they must span at least %g, better 16", span, kLeastSpan);
  const LineFit line = fit_thicknesses(points, reading, "dose");
  const double depth = line.slope.value;
  // ln Ec = mean ln E - mean thickness / Dp, of two independent estimates.
  const double log_critical = line.mean_x - line.mean_y.value / depth;
  check_plausible(windows, depth, std::exp(log_critical));
  const double by_slope = line.mean_y.value * line.slope.uncertainty / (depth * depth);
  const double log_uncertainty = std::hypot(line.mean_y.uncertainty / depth, by_slope);
  return {.penetration_depth_um = line.slope,
          .critical_dose_mj_cm2 = {std::exp(log_critical), std::exp(log_critical) * log_uncertainty},
          .correlation = log_uncertainty > 0 ? by_slope / log_uncertainty : 0,
          .line = line};
}

GammaFit fit_gamma(std::span<const GreyWindow> windows, Estimate penetration_depth_um, Micrometers reading) {
  check_count(windows.size());
  std::vector<MeasuredPoint> points;
  for (const auto& [grey, thickness] : windows) {
    if (grey == 0 || !(thickness.count() > 0))
      refuse(
          "a window of %.4g um at grey %d: both must be more than 0; leave out windows without cured resin",
          thickness.count(), static_cast<int>(grey));
    check_thickness(thickness);
    points.push_back({std::log(grey / 255.0), thickness.count()});
  }
  const auto [darkest, brightest] = std::ranges::minmax(windows, {}, &GreyWindow::grey);
  if (const double span = 1.0 * brightest.grey / darkest.grey; !(span >= kLeastGreySpan - kSpanRounding))
    refuse("the grey values %d to %d span a factor of %.4g: they must span at least %.4g, as 180 to 255 do",
           static_cast<int>(darkest.grey), static_cast<int>(brightest.grey), span, kLeastGreySpan);
  const LineFit line = fit_thicknesses(points, reading, "grey value");
  const double gamma = line.slope.value / penetration_depth_um.value;
  return {.gamma = {gamma, gamma * std::hypot(line.slope.uncertainty / line.slope.value,
                                              penetration_depth_um.uncertainty / penetration_depth_um.value)},
          .line = line};
}

}  // namespace contourd
