#include "core/contour/contour_offset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Corners that are closer than this are merged, because very short sides cross each other when they move.
constexpr double kShortestSide = ContourOffset::kChordError.count();

// Cosine of the sharpest turn at which a corner is mitered. A miter at this turn moves the corner by 2.6
// times the offset distance.
constexpr double kSharpestMiter = -0.7;

Point moved_by(Point point, double factor, Point vector) {
  return {point.x + factor * vector.x, point.y + factor * vector.y};
}

// True if the loop's extent in any of eight directions is at most twice the distance: every point inside the
// loop is then within the distance of the loop, so a move inwards leaves no area. The caller drops such
// loops, because their moved sides would cross each other everywhere.
bool vanishes(std::span<const Point> points, double distance) {
  constexpr double kCos = 0.92387953251128674, kSin = 0.38268343236508977, kHalf = 0.70710678118654752;
  constexpr std::array<Point, 8> kDirections{{{1, 0},
                                              {kCos, kSin},
                                              {kHalf, kHalf},
                                              {kSin, kCos},
                                              {0, 1},
                                              {-kSin, kCos},
                                              {-kHalf, kHalf},
                                              {-kCos, kSin}}};
  for (const Point& direction : kDirections) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Point& point : points) {
      const double at = point.x * direction.x + point.y * direction.y;
      low = std::min(low, at);
      high = std::max(high, at);
    }
    if (high - low <= 2 * distance) return true;
  }
  return false;
}

// Returns twice the enclosed area, positive if the loop runs counter-clockwise.
double twice_the_area(std::span<const Point> points) {
  // Calculated around the first point, where large coordinates cost no digits.
  const Point origin = points.front();
  double sum = 0;
  Point last = points.back();
  for (const Point& point : points) {
    sum += (last.x - origin.x) * (point.y - origin.y) - (point.x - origin.x) * (last.y - origin.y);
    last = point;
  }
  return sum;
}

// Returns the direction to the right: outwards, since solids lie on the left.
Point outward(Point direction) {
  return {direction.y, -direction.x};
}

// Returns the distance by which the contours grow before they shrink: kClosing, or twice the step of a float
// if that is larger, as for contours far from the origin. The upper limit ensures that a single stray facet
// very far away does not close real gaps.
double closing_for(const Contours& contours) {
  constexpr double kStep = 1.0 / (1 << 23);  // step of a float, relative to its value
  constexpr double kMost = 5 * ContourOffset::kClosing.count();
  double reach = 0;
  for (const Point& point : contours.points)
    reach = std::max({reach, std::fabs(point.x), std::fabs(point.y)});
  return std::clamp(2 * kStep * reach, ContourOffset::kClosing.count(), kMost);
}

double length_of(Point vector) {
  return std::sqrt(vector.x * vector.x + vector.y * vector.y);
}

}  // namespace

bool ContourOffset::offset(const Contours& contours, Millimeters distance, Contours& moved,
                           MaskBudget& budget) {
  expects(&contours != &moved, "the moved contours are another object than the contours");
  const double by = distance.count();
  if (by < 0) {
    const double closing = closing_for(contours);
    return close_gaps(contours, closing, budget) && move(closed_, by - closing, Join::Round, moved, budget);
  }
  Contours& outline = by == 0 ? moved : outline_;
  if (!union_.unite(contours, FillRule::NonZero, ContourUnion::kDoubleRounding, outline, budget))
    return false;
  return by == 0 || move(outline_, by, Join::Round, moved, budget);
}

void ContourOffset::offset(const Contours& contours, Millimeters distance, Contours& moved) {
  MaskBudget unlimited;
  if (!offset(contours, distance, moved, unlimited))
    throw std::length_error("the contours cross each other too often");
}

bool ContourOffset::close_gaps(const Contours& contours, double closing, MaskBudget& budget) {
  if (!move(contours, closing, Join::Mitered, closed_, budget)) return false;
  if (!union_.winds_negatively()) return true;
  // A loop runs in the wrong direction. The outline of the union has no such loop, so it is grown instead.
  return union_.unite(contours, FillRule::NonZero, ContourUnion::kDoubleRounding, outline_, budget) &&
         move(outline_, closing, Join::Mitered, closed_, budget);
}

bool ContourOffset::move(const Contours& contours, double distance, Join join, Contours& moved,
                         MaskBudget& budget) {
  distance_ = distance;
  join_ = join;
  raw_.points.clear();
  raw_.loops.clear();
  for (const ContourLoop& loop : contours.loops) {
    move_loop(contours.points_of(loop));
    if (!budget.spend(loop.point_count) || !budget.can_hold(raw_.points.size())) return false;
  }
  return union_.unite(raw_, FillRule::Positive, ContourUnion::kDoubleRounding, moved, budget);
}

void ContourOffset::move_loop(std::span<const Point> points) {
  const auto far_apart = [](Point a, Point b) { return length_of({b.x - a.x, b.y - a.y}) > kShortestSide; };
  corners_.clear();
  for (const Point& point : points) {
    if (corners_.empty() || far_apart(corners_.back(), point)) corners_.push_back(point);
  }
  while (corners_.size() > 1 && !far_apart(corners_.back(), corners_.front()))
    corners_.pop_back();
  if (corners_.size() < 3) return;
  const bool inwards = (twice_the_area(corners_) > 0) == (distance_ < 0);
  if (inwards && vanishes(corners_, std::fabs(distance_))) return;
  const auto first = static_cast<std::uint32_t>(raw_.points.size());
  Corner corner{corners_.back(), {}, {}, 0, 0};
  const auto turn_to = [&corner](Point next) {
    const Point side{next.x - corner.at.x, next.y - corner.at.y};
    corner.into = corner.out_of;
    corner.into_length = corner.out_of_length;
    corner.out_of_length = length_of(side);
    corner.out_of = {side.x / corner.out_of_length, side.y / corner.out_of_length};
  };
  turn_to(corners_.front());
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    corner.at = corners_[i];
    turn_to(corners_[i + 1 < corners_.size() ? i + 1 : 0]);
    move_corner(corner);
  }
  raw_.loops.push_back({first, static_cast<std::uint32_t>(raw_.points.size()) - first});
}

void ContourOffset::move_corner(const Corner& corner) {
  const Point& a = corner.into;
  const Point& b = corner.out_of;
  const double turn = a.x * b.y - a.y * b.x;  // sine of the angle, positive to the left
  const double straight = a.x * b.x + a.y * b.y;
  const Point from = outward(a), to = outward(b);
  if (turn * distance_ > 0 || (turn == 0 && straight < 0)) {
    if (join_ == Join::Mitered && straight > kSharpestMiter) {
      add(moved_by(corner.at, distance_ / (1 + straight), {from.x + to.x, from.y + to.y}));
      return;
    }
    const double side = distance_ < 0 ? -1 : 1;
    add_arc(corner.at, {side * from.x, side * from.y}, {side * to.x, side * to.y}, a);
    return;
  }
  // The moved sides are cut at their crossing, which shortens each of them by distance * tan(angle / 2). Both
  // sides sweep over the area next to the corner; after the cut, that area is swept once instead of twice.
  // Each corner takes at most half of a side, so that the cuts at a side's two ends do not overlap.
  const double shortened = 2 * std::fabs(distance_ * turn);
  if (straight > -1 && shortened <= corner.into_length * (1 + straight) &&
      shortened <= corner.out_of_length * (1 + straight)) {
    add(moved_by(corner.at, distance_ / (1 + straight), {from.x + to.x, from.y + to.y}));
    return;
  }
  add(moved_by(corner.at, distance_, from));
  add(corner.at);
  add(moved_by(corner.at, distance_, to));
}

// Adds the arc from one unit vector to another; `between` is a vector on the arc, used if they are opposite.
void ContourOffset::add_arc(Point center, Point from, Point to, Point between) {
  // The arc is halved until each chord is within kChordError of the arc: each halving quarters the distance
  // between the two. A half turn with a radius of 1 mm takes six halvings.
  constexpr int kMaxHalvings = 10;
  struct Arc {
    Point to;
    int halvings;
  };
  Arc ahead[kMaxHalvings + 1];
  int depth = 0;
  ahead[0] = {to, 0};
  const double radius = std::fabs(distance_);
  add(moved_by(center, radius, from));
  while (depth >= 0) {
    const Arc& arc = ahead[depth];
    const Point sum{from.x + arc.to.x, from.y + arc.to.y};
    const double cosine = length_of(sum) / 2;  // cosine of half the angle
    if (radius * (1 - cosine) <= kChordError.count() || arc.halvings == kMaxHalvings) {
      from = arc.to;
      add(moved_by(center, radius, from));
      --depth;
      continue;
    }
    constexpr double kOpposite = 1e-6;
    const Point middle = cosine > kOpposite ? Point{sum.x / (2 * cosine), sum.y / (2 * cosine)} : between;
    const int halvings = arc.halvings + 1;
    ahead[depth].halvings = halvings;
    ahead[++depth] = {middle, halvings};
  }
}

}  // namespace contourd
