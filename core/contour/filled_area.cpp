#include "core/contour/filled_area.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/contour/contour_union.hpp"

namespace contourd {
namespace {

// Limit on sides; only a soup of facets, no solid, crosses itself more often. Its area is estimated by this
// many lines at equal distances.
constexpr std::size_t kMaxSides = std::size_t{1} << 20;
constexpr int kLines = 500;

double outline_area(const Contours& outline) {
  double sum = 0;
  for (const ContourLoop& loop : outline.loops) {
    const std::span<const Point> points = outline.points_of(loop);
    // Calculated around the first point, where large coordinates cost no digits.
    const Point origin = points.front();
    double twice = 0;
    Point last = points.back();
    for (const Point& p : points) {
      twice += (last.x - origin.x) * (p.y - origin.y) - (p.x - origin.x) * (last.y - origin.y);
      last = p;
    }
    sum += twice / 2;
  }
  return sum;
}

// Returns the filled length along the line at y.
double filled_length(const Contours& contours, double y, std::vector<std::pair<double, int>>& hits) {
  hits.clear();
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    Point a = points.back();
    for (const Point& b : points) {
      if ((a.y <= y) != (b.y <= y))
        hits.push_back({a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x), a.y <= y ? 1 : -1});
      a = b;
    }
  }
  std::sort(hits.begin(), hits.end());
  double length = 0;
  int winding = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (winding != 0) length += hits[i].first - hits[i - 1].first;
    winding += hits[i].second;
  }
  return length;
}

double area_by_few_lines(const Contours& contours) {
  const auto [lowest, highest] = std::minmax_element(contours.points.begin(), contours.points.end(),
                                                     [](Point a, Point b) { return a.y < b.y; });
  const double apart = (highest->y - lowest->y) / kLines;
  std::vector<std::pair<double, int>> hits;
  double sum = 0;
  for (int line = 0; line < kLines; ++line)
    sum += apart * filled_length(contours, lowest->y + apart * (line + 0.5), hits);
  return sum;
}

}  // namespace

double filled_area_mm2(const Contours& contours) {
  // Rounds as finely as the contours' width allows.
  constexpr Millimeters kFinest{1.0 / (std::int64_t{1} << 40)};
  MaskBudget budget(std::nullopt, kMaxSides);
  Contours outline;
  if (!ContourUnion().unite(contours, FillRule::NonZero, kFinest, outline, budget))
    return area_by_few_lines(contours);
  return outline_area(outline);
}

}  // namespace contourd
