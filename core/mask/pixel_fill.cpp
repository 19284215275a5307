#include "core/mask/pixel_fill.hpp"

#include <algorithm>
#include <cmath>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns the height at which two sides cross, if they do: the ends of their common heights lie on different
// sides of each other.
std::optional<double> crossing_of(const PixelSide& a, const PixelSide& b) {
  const double top = std::max(a.top_y, b.top_y), bottom = std::min(a.bottom_y, b.bottom_y);
  if (top >= bottom) return std::nullopt;
  const double at_top = a.x_at(top) - b.x_at(top), at_bottom = a.x_at(bottom) - b.x_at(bottom);
  if ((at_top < 0) == (at_bottom < 0) || at_top == 0 || at_bottom == 0) return std::nullopt;
  return top + (bottom - top) * (at_top / (at_top - at_bottom));
}

}  // namespace

std::optional<double> PixelFill::filled(std::span<const PixelSide> sides,
                                        std::span<const EdgeCrossing> crossings, double mean_winding) {
  expects(sides.size() <= kMostSides && crossings.size() <= kMostSides, "the pixel has few sides");
  // The mean of the winding numbers if that of the upper left corner is 0, and limits of these numbers.
  double mean = 0;
  int lowest = 0;
  for (const PixelSide& side : sides) {
    const double middle_x = side.x_at(0.5 * (side.top_y + side.bottom_y));
    mean += side.sign * (1 - middle_x) * (side.bottom_y - side.top_y);
    lowest += std::min(side.sign, 0);
  }
  for (const EdgeCrossing& crossing : crossings) {
    mean += crossing.change * (1 - crossing.y);
    lowest += std::min(crossing.change, 0);
  }
  constexpr double kMostRounding = 1.0 / 64;
  const double corner = std::floor(mean_winding - mean + 0.5);
  if (std::fabs(mean_winding - mean - corner) > kMostRounding || std::fabs(corner) > 1e6) return std::nullopt;
  const auto corner_winding = static_cast<int>(corner);
  if (corner_winding + lowest > 0) return 1;

  find_heights(sides, crossings);
  double area = 0;
  for (std::size_t i = 1; i < heights_.size(); ++i) {
    const double top = heights_[i - 1], bottom = heights_[i];
    if (top == bottom) continue;
    int winding = corner_winding;
    for (const EdgeCrossing& crossing : crossings)
      if (crossing.y <= top) winding += crossing.change;
    area += filled_width(sides, top, bottom, winding) * (bottom - top);
  }
  return std::clamp(area, 0.0, 1.0);
}

// Finds the heights between which no side begins, ends or crosses another.
void PixelFill::find_heights(std::span<const PixelSide> sides, std::span<const EdgeCrossing> crossings) {
  heights_.assign({0.0, 1.0});
  for (const EdgeCrossing& crossing : crossings)
    heights_.push_back(crossing.y);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    heights_.push_back(sides[i].top_y);
    heights_.push_back(sides[i].bottom_y);
    for (std::size_t k = i + 1; k < sides.size(); ++k)
      if (const auto crossing = crossing_of(sides[i], sides[k])) heights_.push_back(*crossing);
  }
  std::ranges::sort(heights_);
}

// Returns the mean width of the filled part between two heights. `winding`: at the left edge.
double PixelFill::filled_width(std::span<const PixelSide> sides, double top, double bottom, int winding) {
  const double middle = 0.5 * (top + bottom);
  passed_.clear();
  for (const PixelSide& side : sides) {
    if (side.top_y > top || side.bottom_y < bottom) continue;
    const Passed passed{side.x_at(middle), side.sign};
    passed_.push_back(passed);
    std::size_t at = passed_.size() - 1;
    for (; at > 0 && passed_[at - 1].x > passed.x; --at)
      passed_[at] = passed_[at - 1];
    passed_[at] = passed;
  }
  double width = 0, left = 0;
  for (const Passed& side : passed_) {
    if (winding != 0) width += side.x - left;
    left = side.x;
    winding += side.sign;
  }
  return winding != 0 ? width + (1 - left) : width;
}

}  // namespace contourd
