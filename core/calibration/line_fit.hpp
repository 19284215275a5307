// Straight lines through measured points, with the uncertainty of the result. Values and pure functions;
// thread-safe.
#pragma once

#include <span>
#include <stdexcept>

namespace contourd {

// Thrown if measurements do not determine the figures that they are for; what() is one sentence for the
// person who measured.
struct CalibrationRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A figure and its standard uncertainty (one standard deviation), both in the same unit.
struct Estimate {
  double value = 0;
  double uncertainty = 0;
};

struct MeasuredPoint {
  double x = 0, y = 0;
};

// The line y = mean_y + slope (x - mean_x). Its two estimates are independent of each other.
struct LineFit {
  double mean_x = 0;
  Estimate mean_y, slope;
  // Standard deviation of the points about the line, in the unit of y; at least that of a reading.
  double scatter = 0;

  [[nodiscard]] double at(double x) const { return mean_y.value + slope.value * (x - mean_x); }
  // Returns the standard uncertainty of the line's y.
  [[nodiscard]] double uncertainty_at(double x) const;
};

// Returns the line with the least squares of y's differences. `reading` is the standard uncertainty of y by
// the rounding of its readings: points that lie on a line by chance are not better than that. REQUIRES: at
// least three points, two of them with different x.
[[nodiscard]] LineFit fit_line(std::span<const MeasuredPoint> points, double reading = 0);

}  // namespace contourd
