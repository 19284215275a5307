#include "core/contour/contour_union.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

// Join tolerance in grid units: pieces of cut loops meet to the unit, except where bends could not be
// resolved completely.
constexpr double kMeet = 32;

bool filled(int winding, FillRule rule) {
  return rule == FillRule::Positive ? winding > 0 : winding != 0;
}

}  // namespace

bool ContourUnion::unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline,
                         MaskBudget& budget) {
  expects(&contours != &outline, "the outline is another object than the contours");
  outline.points.clear();
  outline.loops.clear();
  outline.cracks = LayerCracks{};
  outline.repaired_loops = 0;
  points_.clear();
  loops_.clear();
  sides_.reset(contours.loops.size());
  if (!budget.can_hold(contours.points.size())) return false;
  choose_grid(contours, rounding);
  for (const ContourLoop& loop : contours.loops)
    take_loop(contours.points_of(loop));
  if (!sides_.arrange(budget)) return false;
  take_whole_loops(rule, outline);
  take_cut_sides(rule);
  if (kept_.empty()) return true;
  linker_.link(kept_, Millimeters{kMeet * unit_}, linked_, budget);
  for (const ContourLoop& loop : linked_.loops) {
    const std::span<const Point> points = linked_.points_of(loop);
    outline.loops.push_back({static_cast<std::uint32_t>(outline.points.size()), loop.point_count});
    outline.points.insert(outline.points.end(), points.begin(), points.end());
  }
  return budget.spend(kept_.size());
}

void ContourUnion::unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline) {
  MaskBudget unlimited;
  if (!unite(contours, rule, rounding, outline, unlimited))
    throw std::length_error("the contours cross each other too often");
}

// Chooses a grid around the middle of the contours, so that all points are within ArrangedSides' reach.
void ContourUnion::choose_grid(const Contours& contours, Millimeters rounding) {
  Point low{0, 0}, high{0, 0};
  if (!contours.points.empty()) low = high = contours.points.front();
  for (const Point& p : contours.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  const double half = std::max(high.x / 2 - low.x / 2, high.y / 2 - low.y / 2);
  unit_ = rounding.count();
  while (half >= unit_ * (ArrangedSides::kReach - 2))
    unit_ *= 2;
  const auto on_grid = [this](double middle) { return std::floor(middle / unit_) * unit_; };
  origin_ = {on_grid(low.x / 2 + high.x / 2), on_grid(low.y / 2 + high.y / 2)};
}

ContourUnion::GridPoint ContourUnion::to_grid(Point point) const {
  return {static_cast<std::int32_t>(std::floor((point.x - origin_.x) / unit_ + 0.5)),
          static_cast<std::int32_t>(std::floor((point.y - origin_.y) / unit_ + 0.5))};
}

Point ContourUnion::to_point(GridPoint point) const {
  return {origin_.x + point.x * unit_ + 0.0, origin_.y + point.y * unit_ + 0.0};
}

void ContourUnion::take_loop(std::span<const Point> points) {
  const auto first = static_cast<std::uint32_t>(points_.size());
  corners_.clear();
  for (const Point& point : points) {
    const GridPoint corner = to_grid(point);
    if (!corners_.empty() && corners_.back() == corner) continue;
    corners_.push_back(corner);
    points_.push_back(point);
  }
  while (corners_.size() > 1 && corners_.back() == corners_.front()) {
    corners_.pop_back();
    points_.pop_back();
  }
  if (corners_.size() < 3) {  // encloses nothing
    points_.resize(first);
    return;
  }
  const auto loop = static_cast<std::uint32_t>(loops_.size());
  const auto side = static_cast<std::uint32_t>(sides_.sides().size());
  for (std::size_t i = 0; i < corners_.size(); ++i)
    sides_.add(corners_[i], corners_[i + 1 < corners_.size() ? i + 1 : 0], loop);
  loops_.push_back({first, static_cast<std::uint32_t>(corners_.size()), side, sides_.sides()[side].turn > 0});
}

void ContourUnion::take_whole_loops(FillRule rule, Contours& outline) const {
  for (std::uint32_t i = 0; i < loops_.size(); ++i) {
    if (sides_.is_cut(i)) continue;
    const Loop& loop = loops_[i];
    const ArrangedSides::Side& side = sides_.sides()[loop.side];
    const bool filled_left = filled(side.winding_left, rule);
    const bool filled_right = filled(side.winding_left - side.turn, rule);
    if (filled_left == filled_right) continue;
    const auto first = outline.points.size();
    const auto begin = points_.begin() + loop.first;
    outline.points.insert(outline.points.end(), begin, begin + loop.count);
    outline.loops.push_back({static_cast<std::uint32_t>(first), loop.count});
    if (loop.upwards != filled_left)
      std::reverse(outline.points.begin() + static_cast<std::ptrdiff_t>(first), outline.points.end());
  }
}

void ContourUnion::take_cut_sides(FillRule rule) {
  kept_.clear();
  for (const ArrangedSides::Side& side : sides_.sides()) {
    if (side.turn == 0 || !sides_.is_cut(side.loop)) continue;
    const bool filled_left = filled(side.winding_left, rule);
    if (filled_left == filled(side.winding_left - side.turn, rule)) continue;
    const Point low = to_point(side.low), high = to_point(side.high);
    kept_.push_back(filled_left ? Segment{low, high} : Segment{high, low});
  }
}

}  // namespace contourd
