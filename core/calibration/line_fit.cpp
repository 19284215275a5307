#include "core/calibration/line_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {

double LineFit::uncertainty_at(double x) const {
  return std::hypot(mean_y.uncertainty, slope.uncertainty * (x - mean_x));
}

LineFit fit_line(std::span<const MeasuredPoint> points, double reading) {
  expects(points.size() >= 3, "fit_line: at least three points");
  const auto count = static_cast<double>(points.size());
  LineFit line;
  for (const MeasuredPoint& point : points) {
    line.mean_x += point.x / count;
    line.mean_y.value += point.y / count;
  }
  double xx = 0, xy = 0;
  for (const MeasuredPoint& point : points) {
    xx += (point.x - line.mean_x) * (point.x - line.mean_x);
    xy += (point.x - line.mean_x) * (point.y - line.mean_y.value);
  }
  expects(xx > 0, "fit_line: points with different x");
  line.slope.value = xy / xx;
  double squares = 0;
  for (const MeasuredPoint& point : points)
    squares += std::pow(point.y - line.at(point.x), 2);
  line.scatter = std::max(std::sqrt(squares / (count - 2)), reading);
  line.slope.uncertainty = line.scatter / std::sqrt(xx);
  line.mean_y.uncertainty = line.scatter / std::sqrt(count);
  return line;
}

}  // namespace contourd
