#include "tests/bench/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace contourd::bench {

double percentile(std::vector<double> values, double percent) {
  // The factor keeps a product that is whole except for rounding (0.99 * 1000) from getting the next rank.
  constexpr double kRounding = 1 - 1e-12;
  const double rank = std::ceil(percent / 100 * static_cast<double>(values.size()) * kRounding);
  const auto index = static_cast<std::size_t>(std::max(rank, 1.0)) - 1;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(index), values.end());
  return values[index];
}

Line fit_line(std::span<const double> x, std::span<const double> y) {
  const auto weight = [&](std::size_t i) { return 1 / (y[i] * y[i]); };
  double weights = 0, mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    weights += weight(i);
    mean_x += weight(i) * x[i];
    mean_y += weight(i) * y[i];
  }
  mean_x /= weights;
  mean_y /= weights;
  double xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += weight(i) * (x[i] - mean_x) * (y[i] - mean_y);
    xx += weight(i) * (x[i] - mean_x) * (x[i] - mean_x);
  }
  Line line{mean_y - xy / xx * mean_x, xy / xx, 0};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double there = line.at_zero + line.slope * x[i];
    line.worst_deviation = std::max(line.worst_deviation, std::fabs((y[i] - there) / there));
  }
  return line;
}

}  // namespace contourd::bench
