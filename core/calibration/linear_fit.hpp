// Linear least squares with several factors. Values and pure functions; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/calibration/line_fit.hpp"

namespace contourd {

// A measured value, which is expected to be the sum of the terms, each multiplied by its factor.
struct LinearPoint {
  std::vector<double> terms;
  double value = 0;
};

struct LinearFit {
  std::vector<double> factors;
  std::vector<double> covariance;  // over the scatter's square, row by row
  double scatter = 0;              // standard deviation of the values about the fit

  // Return the fitted value for terms, and the factor at an index, with their standard uncertainties.
  // REQUIRES: as many terms as factors; an index of a factor.
  [[nodiscard]] Estimate at(std::span<const double> terms) const;
  [[nodiscard]] Estimate factor(std::size_t index) const;
  // Returns the weight that a point's own value has in its fitted value, 0 to 1. REQUIRES: as at().
  [[nodiscard]] double leverage(std::span<const double> terms) const;
};

// Returns the factors with the least squares of the values' differences; nullopt if the points do not
// determine them but for rounding. REQUIRES: more points than terms, all with the same number of terms.
[[nodiscard]] std::optional<LinearFit> fit_linear(std::span<const LinearPoint> points);

}  // namespace contourd
