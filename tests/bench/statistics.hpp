// Statistics of measured numbers. Thread-safe (no shared state).
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace contourd::bench {

// Returns the nearest-rank percentile: the smallest of the values that at least `percent` per cent of all
// values do not exceed. REQUIRES: values is not empty, 0 < percent <= 100.
[[nodiscard]] double percentile(std::vector<double> values, double percent);

[[nodiscard]] inline double median(std::vector<double> values) {
  return percentile(std::move(values), 50);
}

// Returns the smallest value: other programs on the machine can only add to a time. REQUIRES: values is not
// empty.
[[nodiscard]] inline double best(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

// The line y = at_zero + slope x, fitted by least squares of the relative errors, so that small values count
// as much as large ones.
struct Line {
  double at_zero = 0, slope = 0;
  // Deviation of the point farthest from the line, relative to the line's value there.
  double worst_deviation = 0;
};
// Fits a line. REQUIRES: as many y as x, at least two, not all x equal, no y of zero.
[[nodiscard]] Line fit_line(std::span<const double> x, std::span<const double> y);

}  // namespace contourd::bench
