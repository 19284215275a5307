#include "core/calibration/dimension_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/calibration/linear_fit.hpp"
#include "core/calibration/refuse.hpp"

namespace contourd {
namespace {

constexpr std::size_t kLengthsPerFigure = 3;
constexpr double kMostScatterUm = 60;
constexpr double kMostUnsurePercent = 0.3, kMostUnsureUm = 20;
// The limits of a resin's profile.
constexpr double kLeastPercent = -10, kMostPercent = 20, kMostGrowthUm = 500;

// The axes that were measured.
struct MeasuredAxes {
  bool x = false, y = false;
};

// Returns the terms of a length: the scale along each measured axis, and the growth in mm.
std::vector<double> terms_of(const MeasuredLength& length, const MeasuredAxes& axes) {
  std::vector<double> terms;
  if (axes.x) terms.push_back(length.axis == PlateAxis::X ? length.drawn.count() : 0);
  if (axes.y) terms.push_back(length.axis == PlateAxis::Y ? length.drawn.count() : 0);
  terms.push_back(length.kind == LengthKind::Outer ? 2 : -2);
  return terms;
}

void check_lengths(std::span<const MeasuredLength> measured, std::size_t figures) {
  for (const MeasuredLength& length : measured) {
    const double drawn = length.drawn.count(), found = length.measured.count();
    if (!(drawn > 0) || !(found > 0) || std::abs(found - drawn) > 1 + drawn / 5)
      refuse(
          "a length of %.4g mm that measures %.4g mm: no resin is so far off; check the value, and leave out "
          "what is broken",
          drawn, found);
  }
  if (measured.size() < kLengthsPerFigure * figures)
    refuse("%zu lengths do not determine %zu figures: measure at least %zu", measured.size(), figures,
           kLengthsPerFigure * figures);
}

LinearFit fit_lengths(std::span<const MeasuredLength> measured, const MeasuredAxes& axes,
                      Millimeters reading) {
  std::vector<LinearPoint> points;
  for (const MeasuredLength& length : measured)
    points.push_back({terms_of(length, axes), length.measured.count()});
  if (std::optional<LinearFit> fit = fit_linear(points)) {
    fit->scatter = std::max(fit->scatter, reading.count());
    return *std::move(fit);
  }
  throw CalibrationRefused(
      "the lengths are too similar to tell scale from growth: measure long and short ones, from outer side "
      "to outer side and in gaps");
}

// Returns the shrinkage of a resin from the measured `scale` of a part whose model was enlarged to compensate
// for `printed_percent`.
Estimate shrinkage(const Estimate& scale, double printed_percent) {
  const double unshrunk = 1 - printed_percent / 100;
  return {100 * (1 - scale.value * unshrunk), 100 * scale.uncertainty * unshrunk};
}

void check_shrinkage(char axis, const Estimate& percent) {
  if (!(percent.uncertainty <= kMostUnsurePercent))
    refuse(
        "the shrinkage of %.3g %% in %c is uncertain by %.2g %%, more than %g %%: measure longer lengths, "
        "each several times",
        percent.value, axis, percent.uncertainty, kMostUnsurePercent);
  if (percent.value < kLeastPercent || percent.value > kMostPercent)
    refuse(
        "the lengths ask for a shrinkage of %.3g %% in %c, outside of a profile's %g to %g %%: check the "
        "values and the printer's pixel_pitch_um",
        percent.value, axis, kLeastPercent, kMostPercent);
}

void check_growth(const Estimate& um) {
  if (!(um.uncertainty <= kMostUnsureUm))
    refuse(
        "the growth of %.3g um is uncertain by %.2g um, more than %g um: measure each length several times",
        um.value, um.uncertainty, kMostUnsureUm);
  if (std::abs(um.value) > kMostGrowthUm)
    refuse(
        "the lengths ask for a growth of %.4g um, outside of a profile's -%g to %g um: check the values, and "
        "the exposure",
        um.value, kMostGrowthUm, kMostGrowthUm);
}

}  // namespace

DimensionFit fit_dimensions(const DimensionSettings& printed, std::span<const MeasuredLength> measured,
                            Millimeters reading) {
  const auto has = [measured](PlateAxis axis) {
    return std::ranges::any_of(measured, [axis](const MeasuredLength& each) { return each.axis == axis; });
  };
  const MeasuredAxes axes{has(PlateAxis::X), has(PlateAxis::Y)};
  const std::size_t figures = 1U + (axes.x ? 1U : 0U) + (axes.y ? 1U : 0U);
  check_lengths(measured, std::max<std::size_t>(figures, 2));
  const LinearFit lengths = fit_lengths(measured, axes, reading);
  DimensionFit fit;
  fit.scatter_um = lengths.scatter * 1000;
  if (!(fit.scatter_um <= kMostScatterUm))
    refuse(
        "the lengths scatter by %.3g um about those by scale and growth, more than %g um: check which value "
        "belongs to which length",
        fit.scatter_um, kMostScatterUm);
  double unshrunk = 1;
  if (axes.x) {
    fit.shrinkage_x_percent = shrinkage(lengths.factor(0), printed.shrinkage_x_percent);
    check_shrinkage('x', *fit.shrinkage_x_percent);
    unshrunk = 1 - fit.shrinkage_x_percent->value / 100;
  }
  if (axes.y) {
    fit.shrinkage_y_percent = shrinkage(lengths.factor(figures - 2), printed.shrinkage_y_percent);
    check_shrinkage('y', *fit.shrinkage_y_percent);
    const double along_y = 1 - fit.shrinkage_y_percent->value / 100;
    unshrunk = axes.x ? (unshrunk + along_y) / 2 : along_y;
  }
  const auto [growth_mm, growth_uncertainty] = lengths.factor(figures - 1);
  fit.growth_um = {printed.growth_um - growth_mm * 1000 / unshrunk, growth_uncertainty * 1000 / unshrunk};
  check_growth(fit.growth_um);
  for (const MeasuredLength& length : measured)
    fit.lengths_mm.push_back(lengths.at(terms_of(length, axes)));
  return fit;
}

}  // namespace contourd
