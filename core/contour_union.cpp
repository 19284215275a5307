#include "core/contour_union.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace contourd {
namespace {

constexpr std::uint32_t kMostRows = 4096;
// In roundings. How far beside a run of sides one looks: what lies between is no wall and no gap.
constexpr double kBeside = 2;
// The shortest side that is looked at after a longer one has shown nothing.
constexpr double kTelling = 64;
// Ends of cut loops that meet.
constexpr double kMeet = 32;

Point minus(Point a, Point b) {
  return {a.x - b.x, a.y - b.y};
}
double dot(Point a, Point b) {
  return a.x * b.x + a.y * b.y;
}
double cross(Point a, Point b) {
  return a.x * b.y - a.y * b.x;
}
bool filled(int winding, FillRule rule) {
  return rule == FillRule::Positive ? winding > 0 : winding != 0;
}

}  // namespace

void ContourUnion::unite(const Contours& contours, FillRule rule, Millimeters rounding, Contours& outline) {
  same_ = rounding.count();
  outline.points.clear();
  outline.loops.clear();
  outline.cracks = LayerCracks{};
  outline.repaired_loops = 0;
  take_sides(contours);
  if (sides_.empty()) return;
  sort_into_rows();
  cut_where_sides_meet();
  kept_.clear();
  std::size_t cut = 0;
  for (const Loop& loop : loops_) {
    const std::size_t first_cut = cut;
    while (cut < cuts_.size() && cuts_[cut].side < loop.end)
      ++cut;
    const auto begin = sides_.begin() + loop.first, end = sides_.begin() + loop.end;
    if (cut == first_cut && std::none_of(begin, end, [](const Side& side) { return side.cut; })) {
      take_whole_loop(loop, rule, outline);
    } else {
      take_runs(loop, rule);
    }
  }
  if (kept_.empty()) return;
  // Runs too short to be told apart leave such gaps.
  linker_.link(kept_, Millimeters{kMeet * same_}, linked_);
  for (const ContourLoop& loop : linked_.loops) {
    const std::span<const Point> points = linked_.points_of(loop);
    outline.loops.push_back({static_cast<std::uint32_t>(outline.points.size()), loop.point_count});
    outline.points.insert(outline.points.end(), points.begin(), points.end());
  }
}

bool ContourUnion::same(Point a, Point b) const {
  return dot(minus(a, b), minus(a, b)) <= same_ * same_;
}

void ContourUnion::take_sides(const Contours& contours) {
  sides_.clear();
  loops_.clear();
  cuts_.clear();
  for (const ContourLoop& loop : contours.loops)
    take_loop(contours.points_of(loop));
}

void ContourUnion::take_loop(std::span<const Point> points) {
  run_.clear();
  for (const Point& point : points) {
    if (run_.empty() || !same(run_.back(), point)) run_.push_back(point);
  }
  while (run_.size() > 1 && same(run_.back(), run_.front()))
    run_.pop_back();
  if (run_.size() < 3) return;  // encloses nothing
  const auto first = static_cast<std::uint32_t>(sides_.size());
  const auto count = static_cast<std::uint32_t>(run_.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = i + 1 < count ? i + 1 : 0;
    const Point a = run_[i], b = run_[next];
    sides_.push_back({a, b, std::min(a.x, b.x), std::max(a.x, b.x), std::min(a.y, b.y), std::max(a.y, b.y),
                      first + next, 0, false});
  }
  loops_.push_back({first, first + count});
}

std::uint32_t ContourUnion::row_of(double y) const {
  const double row = (y - low_y_) * rows_per_mm_;
  return row <= 0 ? 0 : static_cast<std::uint32_t>(std::min(row, rows_ - 1.0));
}

// Rows as high as the mean side: a side lies in two or three.
void ContourUnion::sort_into_rows() {
  double high_y = sides_.front().high_y, heights = 0;
  low_y_ = sides_.front().low_y;
  for (const Side& side : sides_) {
    low_y_ = std::min(low_y_, side.low_y);
    high_y = std::max(high_y, side.high_y);
    heights += side.high_y - side.low_y;
  }
  const double mean = heights / static_cast<double>(sides_.size());
  const double rows = mean > 0 ? (high_y - low_y_) / mean : 1;
  rows_ = static_cast<std::uint32_t>(std::clamp(rows, 1.0, static_cast<double>(kMostRows)));
  rows_per_mm_ = high_y > low_y_ ? rows_ / (high_y - low_y_) : 0;

  row_end_.assign(rows_ + std::size_t{1}, 0);
  const auto each_row_of = [this](const Side& side, auto&& call) {
    const std::uint32_t last = row_of(side.high_y + same_);
    for (std::uint32_t row = row_of(side.low_y - same_); row <= last; ++row)
      call(row);
  };
  for (Side& side : sides_) {
    side.first_row = row_of(side.low_y - same_);
    each_row_of(side, [this](std::uint32_t row) { ++row_end_[row]; });
  }
  row_begin_.resize(rows_);
  std::uint32_t sum = 0;
  for (std::uint32_t row = 0; row < rows_; ++row) {
    row_begin_[row] = sum;
    sum += row_end_[row];
    row_end_[row] = row_begin_[row];
  }
  in_rows_.resize(sum);
  for (std::uint32_t i = 0; i < sides_.size(); ++i) {
    each_row_of(sides_[i], [this, i](std::uint32_t row) { in_rows_[row_end_[row]++] = i; });
  }
}

void ContourUnion::cut_where_sides_meet() {
  for (std::uint32_t row = 0; row < rows_; ++row) {
    const std::span<std::uint32_t> ids =
        std::span(in_rows_).subspan(row_begin_[row], row_end_[row] - row_begin_[row]);
    std::sort(ids.begin(), ids.end(), [this](std::uint32_t a, std::uint32_t b) {
      return sides_[a].low_x != sides_[b].low_x ? sides_[a].low_x < sides_[b].low_x : a < b;
    });
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const Side& a = sides_[ids[i]];
      for (std::size_t j = i + 1; j < ids.size(); ++j) {
        const Side& b = sides_[ids[j]];
        if (b.low_x > a.high_x + same_) break;
        // Once, though they may share several rows.
        if (row != std::max(a.first_row, b.first_row)) continue;
        if (b.low_y > a.high_y + same_ || a.low_y > b.high_y + same_) continue;
        cut_pair(ids[i], ids[j]);
      }
    }
  }
  std::sort(cuts_.begin(), cuts_.end(), [](const Cut& a, const Cut& b) {
    return a.side != b.side ? a.side < b.side : a.along < b.along;
  });
}

void ContourUnion::cut_pair(std::uint32_t a, std::uint32_t b) {
  const bool a_on_b = cut_by_end(a, b), b_on_a = cut_by_end(b, a);
  if (a_on_b || b_on_a || sides_[a].next == b || sides_[b].next == a) return;
  cut_by_crossing(a, b);
}

// Where the side `end_of` begins on the other side, that one is cut; where it begins in one of its ends,
// their loops are. (Where it ends is where the next one begins, which meets the other as well.)
bool ContourUnion::cut_by_end(std::uint32_t end_of, std::uint32_t other) {
  Side& side = sides_[end_of];
  Side& wall = sides_[other];
  if (wall.next == end_of) return false;
  const Point along = minus(wall.to, wall.from), from = minus(side.from, wall.from);
  if (same(side.from, wall.from)) {
    side.cut = wall.cut = true;
    return true;
  }
  if (same(side.from, wall.to)) {
    side.cut = sides_[wall.next].cut = true;
    return true;
  }
  const double length2 = dot(along, along), reach = dot(along, from), beside = cross(along, from);
  if (reach <= 0 || reach >= length2 || beside * beside > same_ * same_ * length2) return false;
  side.cut = true;
  cuts_.push_back({other, reach / length2, side.from});
  return true;
}

void ContourUnion::cut_by_crossing(std::uint32_t a, std::uint32_t b) {
  const Side& p = sides_[a];
  const Side& q = sides_[b];
  const Point p_along = minus(p.to, p.from), q_along = minus(q.to, q.from);
  const double p_from = cross(q_along, minus(p.from, q.from)), p_to = cross(q_along, minus(p.to, q.from));
  const double q_from = cross(p_along, minus(q.from, p.from)), q_to = cross(p_along, minus(q.to, p.from));
  if ((p_from > 0) == (p_to > 0) || (q_from > 0) == (q_to > 0)) return;
  const double p_at = p_from / (p_from - p_to), q_at = q_from / (q_from - q_to);
  const Point point{p.from.x + p_at * p_along.x, p.from.y + p_at * p_along.y};
  // In an end: the sides that follow meet there as well and are cut there.
  if (same(point, p.to) || same(point, q.to)) return;
  cuts_.push_back({a, p_at, point});
  cuts_.push_back({b, q_at, point});
}

int ContourUnion::winding_at(Point point) const {
  const std::uint32_t row = row_of(point.y);
  int winding = 0;
  for (std::uint32_t i = row_begin_[row]; i < row_end_[row]; ++i) {
    const Side& side = sides_[in_rows_[i]];
    if (side.low_x > point.x) break;  // the row's sides are in this order
    const bool up = side.from.y <= point.y;
    if (up == (side.to.y <= point.y)) continue;
    const double beside = cross(minus(side.to, side.from), minus(point, side.from));
    // The sides left of the point: those that run down have it on their left and turn around it once.
    if (up ? beside < 0 : beside > 0) winding += up ? -1 : 1;
  }
  return winding;
}

int ContourUnion::direction_at(Point from, Point to, FillRule rule) const {
  const Point along = minus(to, from);
  const double step = kBeside * same_ / std::sqrt(dot(along, along));
  const Point middle{(from.x + to.x) / 2, (from.y + to.y) / 2};
  const bool left = filled(winding_at({middle.x - along.y * step, middle.y + along.x * step}), rule);
  const bool right = filled(winding_at({middle.x + along.y * step, middle.y - along.x * step}), rule);
  return static_cast<int>(left) - static_cast<int>(right);
}

int ContourUnion::outline_direction(std::span<const Point> run, FillRule rule) const {
  // Its longest sides are the farthest from what meets it. Where two sides are a wall or a gap too thin to be
  // seen, the next longest knows more.
  constexpr int kMostLooks = 3;
  double shorter_than2 = std::numeric_limits<double>::infinity();
  for (int look = 0; look < kMostLooks; ++look) {
    std::size_t longest = 0;
    double length2 = 0;
    for (std::size_t i = 0; i + 1 < run.size(); ++i) {
      const Point along = minus(run[i + 1], run[i]);
      const double this2 = dot(along, along);
      if (this2 <= length2 || this2 >= shorter_than2) continue;
      length2 = this2;
      longest = i;
    }
    if (length2 == 0 || (look > 0 && length2 < kTelling * kTelling * same_ * same_)) return 0;
    if (const int direction = direction_at(run[longest], run[longest + 1], rule)) return direction;
    shorter_than2 = length2;
  }
  return 0;
}

void ContourUnion::take_whole_loop(const Loop& loop, FillRule rule, Contours& outline) {
  run_.clear();
  for (std::uint32_t i = loop.first; i < loop.end; ++i)
    run_.push_back(sides_[i].from);
  run_.push_back(run_.front());
  const int direction = outline_direction(run_, rule);
  if (direction == 0) return;
  run_.pop_back();
  if (direction < 0) std::reverse(run_.begin(), run_.end());
  outline.loops.push_back(
      {static_cast<std::uint32_t>(outline.points.size()), static_cast<std::uint32_t>(run_.size())});
  outline.points.insert(outline.points.end(), run_.begin(), run_.end());
}

void ContourUnion::take_runs(const Loop& loop, FillRule rule) {
  // All points of the loop and where it is cut.
  run_.clear();
  run_ends_.clear();
  auto cut = std::lower_bound(cuts_.begin(), cuts_.end(), loop.first,
                              [](const Cut& c, std::uint32_t side) { return c.side < side; });
  for (std::uint32_t i = loop.first; i < loop.end; ++i) {
    if (sides_[i].cut) run_ends_.push_back(static_cast<std::uint32_t>(run_.size()));
    run_.push_back(sides_[i].from);
    for (; cut != cuts_.end() && cut->side == i; ++cut) {
      run_ends_.push_back(static_cast<std::uint32_t>(run_.size()));
      run_.push_back(cut->point);
    }
  }
  // From its first cut on, so that every run lies in one piece.
  std::rotate(run_.begin(), run_.begin() + run_ends_.front(), run_.end());
  run_.push_back(run_.front());
  run_ends_.push_back(static_cast<std::uint32_t>(run_.size()) - 1 + run_ends_.front());
  for (std::size_t i = 0; i + 1 < run_ends_.size(); ++i) {
    const std::uint32_t first = run_ends_[i] - run_ends_.front(), last = run_ends_[i + 1] - run_ends_.front();
    take_run(std::span(run_).subspan(first, last - first + 1), rule);
  }
}

void ContourUnion::take_run(std::span<const Point> run, FillRule rule) {
  const int direction = outline_direction(run, rule);
  if (direction == 0) return;
  for (std::size_t i = 0; i + 1 < run.size(); ++i) {
    if (run[i] == run[i + 1]) continue;
    kept_.push_back(direction > 0 ? Segment{run[i], run[i + 1]} : Segment{run[i + 1], run[i]});
  }
}

}  // namespace contourd
