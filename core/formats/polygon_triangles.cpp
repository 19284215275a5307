#include "core/formats/polygon_triangles.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Returns twice the area of a triangle, positive if it turns to the left.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Returns the corners seen along the axis that shows most of the polygon, so that it turns to the left. The
// normal is Newell's: the sum over the sides (Sutherland, Evans 1974).
std::vector<Point> flattened(std::span<const Vertex> corners) {
  std::array<double, 3> normal{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vertex& a = corners[i];
    const Vertex& b = corners[(i + 1) % corners.size()];
    normal[0] += (double{a.y} - b.y) * (double{a.z} + b.z);
    normal[1] += (double{a.z} - b.z) * (double{a.x} + b.x);
    normal[2] += (double{a.x} - b.x) * (double{a.y} + b.y);
  }
  const double x = std::fabs(normal[0]), y = std::fabs(normal[1]), z = std::fabs(normal[2]);
  const std::size_t axis = x > y && x > z ? 0 : y > z ? 1 : 2;
  const double side = normal[axis] < 0 ? -1 : 1;
  std::vector<Point> points;
  points.reserve(corners.size());
  for (const Vertex& corner : corners) {
    const std::array<double, 3> at{corner.x, corner.y, corner.z};
    points.push_back({side * at[(axis + 1) % 3], at[(axis + 2) % 3]});
  }
  return points;
}

class EarCutter {
 public:
  EarCutter(std::span<const Vertex> corners, std::int64_t& tests)
      : corners_(corners), points_(flattened(corners)), tests_(tests) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      left_.push_back(i);
  }

  bool cut(std::vector<Facet>& facets) {
    std::size_t at = 1, since_ear = 0;
    while (left_.size() > 3) {
      at %= left_.size();
      // Without an ear, the polygon crosses itself: any corner is cut.
      const bool is_stuck = since_ear > left_.size();
      if (!is_stuck && !is_ear(at)) {
        if (tests_ < 0) return false;
        ++at, ++since_ear;
        continue;
      }
      add(at, facets);
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(at));
      since_ear = 0;
    }
    add(1, facets);
    return true;
  }

 private:
  [[nodiscard]] std::size_t before(std::size_t at) const {
    return left_[(at + left_.size() - 1) % left_.size()];
  }
  [[nodiscard]] std::size_t after(std::size_t at) const { return left_[(at + 1) % left_.size()]; }

  // True if the triangle at a corner lies within the polygon.
  [[nodiscard]] bool is_ear(std::size_t at) {
    const Point &a = points_[before(at)], &b = points_[left_[at]], &c = points_[after(at)];
    tests_ -= static_cast<std::int64_t>(left_.size());
    if (!(turn(a, b, c) > 0)) return false;
    for (const std::size_t other : left_) {
      const Point& p = points_[other];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  void add(std::size_t at, std::vector<Facet>& facets) const {
    facets.push_back({{corners_[before(at)], corners_[left_[at]], corners_[after(at)]}});
  }

  std::span<const Vertex> corners_;
  std::vector<Point> points_;
  std::vector<std::size_t> left_;  // corners that are not cut yet
  std::int64_t& tests_;
};

}  // namespace

bool add_triangles(std::span<const Vertex> corners, std::vector<Facet>& facets, std::int64_t& tests) {
  expects(corners.size() >= 3, "a polygon has three corners");
  if (corners.size() == 3) {
    facets.push_back({{corners[0], corners[1], corners[2]}});
    return true;
  }
  return EarCutter(corners, tests).cut(facets);
}

}  // namespace contourd
