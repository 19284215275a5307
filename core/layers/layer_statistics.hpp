// The thesis's measurements of a sliced model: the slicing and contour times, intersecting facets and loop
// count by layer (tables 4.1 to 4.4, 4.6), their means and standard deviations, and their correlation (table
// 4.5). Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/units.hpp"

namespace contourd {

struct LayerMeasurement {
  Millimeters z{};  // height of the cut, in the model's coordinates
  double slicing_ms = 0;
  double contour_ms = 0;
  std::uint32_t intersecting_facets = 0;
  std::uint32_t loop_count = 0;

  [[nodiscard]] double total_ms() const { return slicing_ms + contour_ms; }
};

struct MeanAndDeviation {
  double mean = 0;
  double deviation = 0;  // sample deviation, divided by n - 1, like MATLAB's std()
};

struct LayerStatistics {
  MeanAndDeviation slicing_ms, contour_ms, total_ms, intersecting_facets, loop_count;
  // The correlation (equation 4.1) of contour time with loop count and with intersecting facets. 0 if a
  // series is all zero.
  double contour_time_vs_loop_count = 0;
  double contour_time_vs_intersecting_facets = 0;
};

[[nodiscard]] LayerStatistics statistics_of(std::span<const LayerMeasurement> layers);

// Returns the thesis's equation 4.1: sum(x y) / sqrt(sum(x^2) sum(y^2)). REQUIRES: equal sizes.
[[nodiscard]] double normalized_correlation(std::span<const double> x, std::span<const double> y);

}  // namespace contourd
