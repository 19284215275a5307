#include "core/layers/layer_statistics.hpp"

#include <cmath>
#include <numeric>
#include <vector>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

template <typename Value>
std::vector<double> series(std::span<const LayerMeasurement> layers, Value&& value) {
  std::vector<double> values;
  values.reserve(layers.size());
  for (const LayerMeasurement& layer : layers)
    values.push_back(static_cast<double>(value(layer)));
  return values;
}

MeanAndDeviation mean_and_deviation(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values)
    squares += (value - mean) * (value - mean);
  return {mean, n > 1 ? std::sqrt(squares / (n - 1)) : 0.0};
}

}  // namespace

double normalized_correlation(std::span<const double> x, std::span<const double> y) {
  expects(x.size() == y.size(), "both series have the same length");
  const double xy = std::inner_product(x.begin(), x.end(), y.begin(), 0.0);
  const double xx = std::inner_product(x.begin(), x.end(), x.begin(), 0.0);
  const double yy = std::inner_product(y.begin(), y.end(), y.begin(), 0.0);
  return xx > 0 && yy > 0 ? xy / std::sqrt(xx * yy) : 0.0;
}

LayerStatistics statistics_of(std::span<const LayerMeasurement> layers) {
  const auto slicing = series(layers, [](const LayerMeasurement& l) { return l.slicing_ms; });
  const auto contour = series(layers, [](const LayerMeasurement& l) { return l.contour_ms; });
  const auto total = series(layers, [](const LayerMeasurement& l) { return l.total_ms(); });
  const auto facets = series(layers, [](const LayerMeasurement& l) { return l.intersecting_facets; });
  const auto loops = series(layers, [](const LayerMeasurement& l) { return l.loop_count; });
  return {mean_and_deviation(slicing),
          mean_and_deviation(contour),
          mean_and_deviation(total),
          mean_and_deviation(facets),
          mean_and_deviation(loops),
          normalized_correlation(contour, loops),
          normalized_correlation(contour, facets)};
}

}  // namespace contourd
