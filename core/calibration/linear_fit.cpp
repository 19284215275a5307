#include "core/calibration/linear_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns the inverse of a symmetric positive matrix (Gauss and Jordan); nullopt if it is singular but for
// rounding.
std::optional<std::vector<double>> inverse_of(std::vector<double> matrix, std::size_t side) {
  std::vector<double> inverse(side * side, 0);
  for (std::size_t i = 0; i < side; ++i)
    inverse[i * side + i] = 1;
  for (std::size_t pivot = 0; pivot < side; ++pivot) {
    const double by = matrix[pivot * side + pivot];
    if (!(by > 1e-6)) return std::nullopt;
    for (std::size_t column = 0; column < side; ++column) {
      matrix[pivot * side + column] /= by;
      inverse[pivot * side + column] /= by;
    }
    for (std::size_t row = 0; row < side; ++row) {
      const double times = matrix[row * side + pivot];
      if (row == pivot) continue;
      for (std::size_t column = 0; column < side; ++column) {
        matrix[row * side + column] -= times * matrix[pivot * side + column];
        inverse[row * side + column] -= times * inverse[pivot * side + column];
      }
    }
  }
  return inverse;
}

}  // namespace

Estimate LinearFit::at(std::span<const double> terms) const {
  expects(terms.size() == factors.size(), "a fit has a factor for each term");
  double value = 0;
  for (std::size_t i = 0; i < terms.size(); ++i)
    value += terms[i] * factors[i];
  return {value, scatter * std::sqrt(leverage(terms))};
}

Estimate LinearFit::factor(std::size_t index) const {
  expects(index < factors.size(), "a fit has this factor");
  return {factors[index], scatter * std::sqrt(covariance[index * factors.size() + index])};
}

double LinearFit::leverage(std::span<const double> terms) const {
  expects(terms.size() == factors.size(), "a fit has a factor for each term");
  double sum = 0;
  for (std::size_t i = 0; i < terms.size(); ++i)
    for (std::size_t j = 0; j < terms.size(); ++j)
      sum += terms[i] * covariance[i * terms.size() + j] * terms[j];
  return std::max(sum, 0.0);
}

std::optional<LinearFit> fit_linear(std::span<const LinearPoint> points) {
  expects(!points.empty() && points.size() > points[0].terms.size(), "fit_linear: more points than terms");
  const std::size_t count = points[0].terms.size();
  std::vector<double> normal(count * count, 0), sums(count, 0);
  for (const auto& [terms, value] : points) {
    expects(terms.size() == count, "fit_linear: points with the same number of terms");
    for (std::size_t i = 0; i < count; ++i) {
      sums[i] += terms[i] * value;
      for (std::size_t j = 0; j < count; ++j)
        normal[i * count + j] += terms[i] * terms[j];
    }
  }
  std::optional<std::vector<double>> inverse = inverse_of(std::move(normal), count);
  if (!inverse) return std::nullopt;
  LinearFit fit{.factors = std::vector<double>(count, 0), .covariance = *std::move(inverse)};
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = 0; j < count; ++j)
      fit.factors[i] += fit.covariance[i * count + j] * sums[j];
  double squares = 0;
  for (const auto& [terms, value] : points)
    squares += std::pow(value - fit.at(terms).value, 2);
  fit.scatter = std::sqrt(squares / static_cast<double>(points.size() - count));
  return fit;
}

}  // namespace contourd
