#include "core/filled_area.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace contourd {
namespace {

// Sides that cross each other within a strip split it. A strip with more crossings than this (a soup of
// facets, not a solid) is measured on its middle line alone.
constexpr std::size_t kMostCrossings = 4096;

// How often a side may be looked at, all lines together (some seconds). Where that does not do, so many lines
// at equal distances tell what they can.
constexpr std::size_t kMostLooks = 100'000'000;
constexpr int kLines = 500;

struct Side {
  Point low, high;  // low.y < high.y
  int winding;      // +1 when it runs upwards
};

double x_at(const Side& side, double y) {
  return side.low.x + (y - side.low.y) / (side.high.y - side.low.y) * (side.high.x - side.low.x);
}

std::vector<Side> sides_of(const Contours& contours) {
  std::vector<Side> sides;
  sides.reserve(contours.points.size());
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& a = points[i];
      const Point& b = points[i + 1 < points.size() ? i + 1 : 0];
      if (a.y < b.y) sides.push_back({a, b, 1});
      if (b.y < a.y) sides.push_back({b, a, -1});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.low.y < b.low.y; });
  return sides;
}

// Sweeps a horizontal line upwards over strips between the sides' end points. Within a strip no side ends, so
// the filled length along the line grows linearly between crossings, and its value in the middle is its mean.
class Sweep {
 public:
  explicit Sweep(std::vector<Side> sides) : sides_(std::move(sides)) {}

  double area() {
    std::vector<double> ends;
    for (const Side& side : sides_) {
      ends.push_back(side.low.y);
      ends.push_back(side.high.y);
    }
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    double sum = 0;
    std::size_t next = 0;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      std::erase_if(active_, [&](std::size_t s) { return sides_[s].high.y <= ends[i]; });
      for (; next < sides_.size() && sides_[next].low.y <= ends[i]; ++next)
        active_.push_back(next);
      sum += strip_area(ends[i], ends[i + 1]);
      if (looks_ > kMostLooks) return area_by_few_lines(ends.front(), ends.back());
    }
    return sum;
  }

 private:
  double strip_area(double bottom, double top) {
    find_crossings(bottom, top);
    double sum = 0;
    double from = bottom;
    for (const double crossing : crossings_) {
      if (looks_ > kMostLooks) return 0;  // area() counts anew, on few lines
      sum += (crossing - from) * filled_length(from + (crossing - from) / 2);
      from = crossing;
    }
    return sum + (top - from) * filled_length(from + (top - from) / 2);
  }

  double area_by_few_lines(double bottom, double top) {
    const double apart = (top - bottom) / kLines;
    double sum = 0;
    for (int line = 0; line < kLines; ++line) {
      const double y = bottom + apart * (line + 0.5);
      active_.clear();
      for (std::size_t s = 0; s < sides_.size() && sides_[s].low.y <= y; ++s) {
        if (sides_[s].high.y > y) active_.push_back(s);
      }
      sum += apart * filled_length(y);
    }
    return sum;
  }

  // Heights strictly within the strip where two active sides change places, ascending.
  void find_crossings(double bottom, double top) {
    crossings_.clear();
    order_.clear();
    for (const std::size_t s : active_)
      order_.push_back({x_at(sides_[s], bottom), x_at(sides_[s], top)});
    std::sort(order_.begin(), order_.end());
    // The largest x at the top so far tells whether a side has crossed any before it.
    double rightmost = -HUGE_VAL;
    for (std::size_t j = 0; j < order_.size(); ++j) {
      if (order_[j].second < rightmost) add_crossings_before(j, bottom, top);
      if (crossings_.size() > kMostCrossings || looks_ > kMostLooks) {
        crossings_.clear();
        return;
      }
      rightmost = std::max(rightmost, order_[j].second);
    }
    std::sort(crossings_.begin(), crossings_.end());
  }

  void add_crossings_before(std::size_t j, double bottom, double top) {
    looks_ += j;
    for (std::size_t i = 0; i < j; ++i) {
      const double apart_at_bottom = order_[j].first - order_[i].first;
      const double apart_at_top = order_[i].second - order_[j].second;
      if (!(apart_at_top > 0.0)) continue;
      const double y = bottom + (top - bottom) * (apart_at_bottom / (apart_at_bottom + apart_at_top));
      if (y > bottom && y < top) crossings_.push_back(y);
    }
  }

  double filled_length(double y) {
    hits_.clear();
    looks_ += active_.size();
    for (const std::size_t s : active_)
      hits_.push_back({x_at(sides_[s], y), sides_[s].winding});
    std::sort(hits_.begin(), hits_.end());
    double length = 0;
    int winding = 0;
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      if (winding != 0) length += hits_[i].first - hits_[i - 1].first;
      winding += hits_[i].second;
    }
    return length;
  }

  std::vector<Side> sides_;
  std::size_t looks_ = 0;
  std::vector<std::size_t> active_;
  std::vector<double> crossings_;
  std::vector<std::pair<double, double>> order_;
  std::vector<std::pair<double, int>> hits_;
};

}  // namespace

double filled_area_mm2(const Contours& contours) {
  return Sweep(sides_of(contours)).area();
}

}  // namespace contourd
