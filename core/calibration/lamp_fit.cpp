#include "core/calibration/lamp_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/calibration/refuse.hpp"

namespace contourd {
namespace {

constexpr std::size_t kFewestReadings = 9, kFewestLines = 3;
constexpr double kMostLight = 1e9;
constexpr double kLeastExtent = 0.6;       // distance of the readings, as a share of the display's side
constexpr double kMostScatterPercent = 6;  // share of the mean light
constexpr double kMostUnevenPercent = 5;   // share of the light at a place
constexpr double kMostTimesDarkest = 5;    // brighter than that, a mask would have few steps
constexpr int kPlaces = 65;                // along each side, where a surface is looked at
constexpr double kMaskStepPercent = 100.0 / 255;
constexpr std::array kDegrees{2, 3, 4};
constexpr std::size_t kLeastFreedom = 3;  // readings more than terms
constexpr double kClearlyBetter = 0.9;    // share of the error of prediction of a lower degree

std::vector<double> terms_at(LampPlace place, int degree) {
  std::vector<double> terms;
  for (int sum = 0; sum <= degree; ++sum)
    for (int of_y = 0; of_y <= sum; ++of_y)
      terms.push_back(std::pow(place.x, sum - of_y) * std::pow(place.y, of_y));
  return terms;
}

// Calls `see` for places over the whole display, edges included.
template <typename See>
void for_each_place(See see) {
  for (int row = 0; row < kPlaces; ++row)
    for (int column = 0; column < kPlaces; ++column)
      see(LampPlace{2.0 * column / (kPlaces - 1) - 1, 2.0 * row / (kPlaces - 1) - 1});
}

// Checks one coordinate of the readings' places; `lines` are its values.
void check_extent(const std::set<double>& lines, const char* kind, const char* side) {
  if (lines.size() < kFewestLines)
    refuse(
        "the readings lie in %zu %s of places: measure in at least %zu, better in a grid of 5 columns and 3 "
        "rows",
        lines.size(), kind, kFewestLines);
  const double extent = (*lines.rbegin() - *lines.begin()) / 2;
  if (extent < kLeastExtent - 1e-9)
    refuse(
        "the readings extend over %.3g %% of the picture's %s: they must extend over at least %.3g %%, since "
        "the "
        "light beyond them is guessed",
        extent * 100, side, kLeastExtent * 100);
}

void check_readings(std::span<const LampReading> readings) {
  std::set<double> columns, rows;
  for (std::size_t i = 0; i < readings.size() && i < kMostLampReadings; ++i) {
    const auto& [place, light] = readings[i];
    if (!(light > 0) || !(light <= kMostLight))
      refuse(
          "reading %zu is %.4g: a reading is more than 0 and at most %g; leave out places that were not "
          "measured",
          i + 1, light, kMostLight);
    if (!(std::abs(place.x) <= 1) || !(std::abs(place.y) <= 1))
      refuse("reading %zu is of a place beside the picture", i + 1);
    columns.insert(place.x);
    rows.insert(place.y);
  }
  if (readings.size() < kFewestReadings || readings.size() > kMostLampReadings)
    refuse("%zu readings do not determine a lamp's light: give %zu to %zu, better 15 or more",
           readings.size(), kFewestReadings, kMostLampReadings);
  check_extent(columns, "columns", "width");
  check_extent(rows, "rows", "height");
}

// A surface, and the mean square of the error with which it predicts each reading from the others.
struct PredictingSurface {
  LampSurface surface;
  double error = 0;
};

// Returns the surface of a degree, unless the readings do not determine it.
std::optional<PredictingSurface> fit_surface(std::span<const LampReading> readings, int degree) {
  std::vector<LinearPoint> points;
  for (const auto& [place, light] : readings)
    points.push_back({terms_at(place, degree), light});
  if (points.size() < points.front().terms.size() + kLeastFreedom) return std::nullopt;
  std::optional<LinearFit> fit = fit_linear(points);
  if (!fit) return std::nullopt;
  double squares = 0;
  for (const auto& [terms, light] : points) {
    const double rest = 1 - fit->leverage(terms);
    if (rest < 1e-9) return std::nullopt;  // the surface goes through this reading whatever it is
    squares += std::pow((light - fit->at(terms).value) / rest, 2);
  }
  return PredictingSurface{{degree, *std::move(fit)}, squares / static_cast<double>(points.size())};
}

LampSurface best_surface(std::span<const LampReading> readings) {
  std::optional<PredictingSurface> best;
  for (const int degree : kDegrees) {
    const std::optional<PredictingSurface> fitted = fit_surface(readings, degree);
    if (fitted && (!best || fitted->error < kClearlyBetter * best->error)) best = fitted;
  }
  if (!best)
    refuse(
        "the places of the %zu readings do not determine a surface: measure in a grid, 5 columns and 3 rows",
        readings.size());
  return best->surface;
}

void check_surface(const LampFit& lamp, std::span<const LampReading> readings) {
  double mean = 0;
  for (const LampReading& reading : readings)
    mean += reading.light / static_cast<double>(readings.size());
  if (const double scatter = 100 * lamp.surface.fit.scatter / mean; !(scatter <= kMostScatterPercent))
    refuse(
        "the readings scatter by %.3g %% about the best smooth surface, more than %g %%: check which reading "
        "belongs to which place, and measure each place several times",
        scatter, kMostScatterPercent);
  if (!(lamp.darkest.light * kMostTimesDarkest > lamp.brightest.light))
    refuse(
        "by the readings the light falls from %.4g to %.4g: at more than %g times the darkest place's light, "
        "a "
        "mask cannot even it out; check the readings and the projector's optics",
        lamp.brightest.light, lamp.darkest.light, kMostTimesDarkest);
  if (!(lamp.worst_percent <= kMostUnevenPercent))
    refuse(
        "the light at the most uncertain place is known within %.3g %% (one standard deviation), %g %% are "
        "allowed: measure more places, and closer to the edges",
        lamp.worst_percent, kMostUnevenPercent);
  if (!(lamp.spread_after_percent < lamp.spread_percent))
    refuse(
        "the lamp's light differs by %.3g %%, and with the mask of these readings it might still differ by "
        "%.3g %%: measure more exactly, or leave the lamp as it is",
        lamp.spread_percent, lamp.spread_after_percent);
}

// Returns the factors of 1, x, x² and so on along a row of the display.
std::vector<double> factors_along(const LampSurface& surface, double y) {
  std::vector<double> along(static_cast<std::size_t>(surface.degree) + 1, 0);
  auto factor = surface.fit.factors.begin();
  for (int sum = 0; sum <= surface.degree; ++sum)
    for (int of_y = 0; of_y <= sum; ++of_y)
      along[static_cast<std::size_t>(sum - of_y)] += *factor++ * std::pow(y, of_y);
  return along;
}

}  // namespace

Estimate LampSurface::at(LampPlace place) const {
  return fit.at(terms_at(place, degree));
}

LampFit fit_lamp(std::span<const LampReading> readings) {
  check_readings(readings);
  LampFit lamp{.surface = best_surface(readings), .darkest = {}, .brightest = {}};
  lamp.darkest.light = std::numeric_limits<double>::infinity();
  for_each_place([&lamp](LampPlace place) {
    const auto [light, uncertainty] = lamp.surface.at(place);
    if (light < lamp.darkest.light) lamp.darkest = {place, light};
    if (light > lamp.brightest.light) lamp.brightest = {place, light};
    lamp.worst_percent = std::max(lamp.worst_percent, 100 * uncertainty / light);
  });
  const double ratio = lamp.brightest.light / lamp.darkest.light;
  lamp.spread_percent = 100 * (ratio - 1);
  lamp.spread_after_percent = 2 * 2 * lamp.worst_percent + kMaskStepPercent * ratio;
  check_surface(lamp, readings);
  return lamp;
}

Mask draw_uniformity_mask(const LampFit& lamp, Pixels width, Pixels height) {
  Mask mask(width, height);
  for (std::int32_t row = 0; row < height.count(); ++row) {
    const std::vector<double> factors = factors_along(lamp.surface, 2 * (row + 0.5) / height.count() - 1);
    std::int32_t column = 0;
    for (std::uint8_t& share : mask.row(row)) {
      const double x = 2 * (column++ + 0.5) / width.count() - 1;
      double light = 0;
      for (auto factor = factors.rbegin(); factor != factors.rend(); ++factor)
        light = light * x + *factor;
      share = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, lamp.darkest.light / light)));
    }
  }
  return mask;
}

}  // namespace contourd
