#include "core/calibration/dimension_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/calibration/refuse.hpp"

namespace contourd {
namespace {

constexpr std::size_t kLengthsPerFigure = 3;
constexpr double kMostScatterUm = 60;
constexpr double kMostUnsurePercent = 0.3, kMostUnsureUm = 20;
// The limits of a resin's profile.
constexpr double kLeastPercent = -10, kMostPercent = 20, kMostGrowthUm = 500;

// Figures of the fit: the scale in x, that in y, the growth in mm.
using Row = std::array<double, 3>;
using Matrix = std::array<Row, 3>;

Row row_of(const MeasuredLength& length) {
  const double drawn = length.drawn.count();
  return {length.axis == PlateAxis::X ? drawn : 0, length.axis == PlateAxis::Y ? drawn : 0,
          length.kind == LengthKind::Outer ? 2.0 : -2.0};
}

// Inverts a symmetric positive matrix (Gauss and Jordan). Returns false if it is singular but for rounding.
bool invert(Matrix& matrix, const std::array<bool, 3>& is_used) {
  Matrix inverse{};
  for (std::size_t i = 0; i < 3; ++i) {
    inverse[i][i] = 1;
    if (!is_used[i]) matrix[i][i] = 1;
  }
  for (std::size_t pivot = 0; pivot < 3; ++pivot) {
    const double by = matrix[pivot][pivot];
    if (!(by > 1e-6)) return false;
    for (std::size_t column = 0; column < 3; ++column) {
      matrix[pivot][column] /= by;
      inverse[pivot][column] /= by;
    }
    for (std::size_t row = 0; row < 3; ++row) {
      const double times = matrix[row][pivot];
      if (row == pivot) continue;
      for (std::size_t column = 0; column < 3; ++column) {
        matrix[row][column] -= times * matrix[pivot][column];
        inverse[row][column] -= times * inverse[pivot][column];
      }
    }
  }
  matrix = inverse;
  return true;
}

// The scales and the growth that the lengths have, in the part.
struct LengthFit {
  std::array<Estimate, 3> figures;  // as in Row
  double scatter_mm = 0;
};

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

LengthFit fit_lengths(std::span<const MeasuredLength> measured, const std::array<bool, 3>& is_used,
                      std::size_t figures) {
  Matrix covariance{};
  Row sums{};
  for (const MeasuredLength& length : measured) {
    const Row row = row_of(length);
    for (std::size_t i = 0; i < 3; ++i) {
      sums[i] += row[i] * length.measured.count();
      for (std::size_t j = 0; j < 3; ++j)
        covariance[i][j] += row[i] * row[j];
    }
  }
  if (!invert(covariance, is_used))
    throw CalibrationRefused(
        "the lengths are too similar to tell scale from growth: measure long and short ones, from outer side "
        "to outer side and in gaps");
  LengthFit fit;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      fit.figures[i].value += covariance[i][j] * sums[j];
  double squares = 0;
  for (const MeasuredLength& length : measured) {
    const Row row = row_of(length);
    double expected = 0;
    for (std::size_t i = 0; i < 3; ++i)
      expected += row[i] * fit.figures[i].value;
    squares += std::pow(length.measured.count() - expected, 2);
  }
  fit.scatter_mm = std::sqrt(squares / static_cast<double>(measured.size() - figures));
  for (std::size_t i = 0; i < 3; ++i)
    fit.figures[i].uncertainty = fit.scatter_mm * std::sqrt(covariance[i][i]);
  return fit;
}

// Returns the shrinkage of parts whose models were enlarged for another one, and have this scale.
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

DimensionFit fit_dimensions(const DimensionSettings& printed, std::span<const MeasuredLength> measured) {
  const auto has = [measured](PlateAxis axis) {
    return std::ranges::any_of(measured, [axis](const MeasuredLength& each) { return each.axis == axis; });
  };
  const std::array<bool, 3> is_used{has(PlateAxis::X), has(PlateAxis::Y), true};
  const auto figures = static_cast<std::size_t>(std::ranges::count(is_used, true));
  check_lengths(measured, std::max<std::size_t>(figures, 2));
  const auto& [of, scatter_mm] = fit_lengths(measured, is_used, figures);
  if (!(scatter_mm * 1000 <= kMostScatterUm))
    refuse(
        "the lengths scatter by %.3g um about those by scale and growth, more than %g um: check which value "
        "belongs to which length",
        scatter_mm * 1000, kMostScatterUm);
  DimensionFit fit;
  fit.scatter_um = scatter_mm * 1000;
  double unshrunk = 1;
  if (is_used[0]) {
    fit.shrinkage_x_percent = shrinkage(of[0], printed.shrinkage_x_percent);
    check_shrinkage('x', *fit.shrinkage_x_percent);
    unshrunk = 1 - fit.shrinkage_x_percent->value / 100;
  }
  if (is_used[1]) {
    fit.shrinkage_y_percent = shrinkage(of[1], printed.shrinkage_y_percent);
    check_shrinkage('y', *fit.shrinkage_y_percent);
    const double along_y = 1 - fit.shrinkage_y_percent->value / 100;
    unshrunk = is_used[0] ? (unshrunk + along_y) / 2 : along_y;
  }
  fit.growth_um = {printed.growth_um - of[2].value * 1000 / unshrunk, of[2].uncertainty * 1000 / unshrunk};
  check_growth(fit.growth_um);
  return fit;
}

}  // namespace contourd
