// What the benchmark makes of many measured numbers. Thread-safe (no shared state).
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

namespace contourd::bench {

// The nearest-rank percentile: the smallest value that at least `percent` per cent of all values do not
// exceed; always one of them. REQUIRES: values is not empty, 0 < percent <= 100.
[[nodiscard]] double percentile(std::vector<double> values, double percent);

[[nodiscard]] inline double median(std::vector<double> values) {
  return percentile(std::move(values), 50);
}

// The least of them: what others on the machine do can only add to a time. REQUIRES: values is not empty.
[[nodiscard]] inline double best(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

// y = at_zero + slope x, by least squares of the relative errors, so that small values count as much as large
// ones.
struct Line {
  double at_zero = 0, slope = 0;
  // The point farthest from the line, as a part of the line's value there.
  double worst_deviation = 0;
};
// REQUIRES: as many y as x, at least two, not all x equal, no y of zero.
[[nodiscard]] Line fit_line(std::span<const double> x, std::span<const double> y);

}  // namespace contourd::bench
