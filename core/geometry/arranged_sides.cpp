#include "core/geometry/arranged_sides.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

using GridPoint = ArrangedSides::GridPoint;
using Side = ArrangedSides::Side;

// Limit on sweeps. Each sweep after the first only handles what the previous one has bent by up to a unit:
// dense tangles take up to six.
constexpr int kMaxSweeps = 64;

std::uint64_t order_of(GridPoint p) {
  constexpr std::int64_t kOffset = ArrangedSides::kReach;
  return static_cast<std::uint64_t>(p.y + kOffset) << 32U | static_cast<std::uint64_t>(p.x + kOffset);
}

GridPoint point_of(std::uint64_t order) {
  constexpr std::int64_t kOffset = ArrangedSides::kReach;
  return {static_cast<std::int32_t>(static_cast<std::int64_t>(order & 0xFFFFFFFFU) - kOffset),
          static_cast<std::int32_t>(static_cast<std::int64_t>(order >> 32U) - kOffset)};
}

// Returns a positive number if `p` lies left of the side, 0 if it lies on the side's line.
std::int64_t off_line(const Side& side, GridPoint p) {
  return std::int64_t{side.high.x - side.low.x} * (p.y - side.low.y) -
         std::int64_t{side.high.y - side.low.y} * (p.x - side.low.x);
}

// Returns a positive number if `b` leads further to the left than `a`.
std::int64_t turn_to_left(const Side& a, const Side& b) {
  return std::int64_t{a.high.x - a.low.x} * (b.high.y - b.low.y) -
         std::int64_t{a.high.y - a.low.y} * (b.high.x - b.low.x);
}

std::int64_t length_of(const Side& side) {
  return std::max(std::abs(std::int64_t{side.high.x} - side.low.x), std::int64_t{side.high.y} - side.low.y);
}

// Returns the crossing, rounded to the grid: upwards if the nearest point has been swept. REQUIRES: the sides
// are not parallel.
GridPoint crossing_of(const Side& a, const Side& b, GridPoint swept_to) {
  expects_costly([&] { return turn_to_left(a, b) != 0; }, "the sides are not parallel");
  const double part = static_cast<double>(off_line(b, a.low)) / -static_cast<double>(turn_to_left(b, a));
  const double x = a.low.x + part * (a.high.x - a.low.x), y = a.low.y + part * (a.high.y - a.low.y);
  const auto [low_x, high_x] = std::minmax(a.low.x, a.high.x);
  const GridPoint nearest{std::clamp(static_cast<std::int32_t>(std::floor(x + 0.5)), low_x, high_x),
                          std::clamp(static_cast<std::int32_t>(std::floor(y + 0.5)), a.low.y, a.high.y)};
  if (order_of(nearest) > order_of(swept_to) || y <= swept_to.y) return nearest;
  return {nearest.x, swept_to.y + 1};
}

}  // namespace

void ArrangedSides::reset(std::size_t loops) {
  sides_.clear();
  loop_is_cut_.assign(loops, 0);
}

void ArrangedSides::add(GridPoint from, GridPoint to, std::uint32_t loop) {
  const std::uint64_t from_order = order_of(from), to_order = order_of(to);
  if (from_order < to_order) sides_.push_back({from, to, 1, 0, loop});
  if (to_order < from_order) sides_.push_back({to, from, -1, 0, loop});
}

bool ArrangedSides::arrange(MaskBudget& budget) {
  for (int i = 0; i < kMaxSweeps; ++i) {
    if (!sweep(budget)) return false;
    if (!bent_) break;
  }
  return true;
}

bool ArrangedSides::sweep(MaskBudget& budget) {
  bent_ = false;
  winds_negatively_ = false;
  make_events();
  for (GridPoint point; take_events(point);) {
    if (!budget.spend(ending_.size() + beginning_.size()) || !budget.can_hold(sides_.size())) return false;
    pass(point);
  }
  return true;
}

// Collects the ends of all sides in order: distributes them over rows of equal height with a few events each,
// then sorts each row.
void ArrangedSides::make_events() {
  queue_.clear();
  next_event_ = 0;
  order_.clear();
  order_.reserve_numbers(sides_.size());
  std::int32_t low_y = kReach, high_y = -kReach;
  std::uint32_t count = 0;
  for (const Side& side : sides_) {
    if (side.turn == 0) continue;
    low_y = std::min(low_y, side.low.y);
    high_y = std::max(high_y, side.high.y);
    ++count;
  }
  events_.resize(std::size_t{count} * 2);
  if (count == 0) return;
  const auto height = static_cast<std::uint32_t>(high_y - low_y);
  const int shift =
      std::max(0, static_cast<int>(std::bit_width(height)) - static_cast<int>(std::bit_width(count)));
  const auto row_of = [low_y, shift](GridPoint p) {
    return static_cast<std::uint32_t>(p.y - low_y) >> shift;
  };
  row_end_.assign((height >> shift) + std::size_t{1}, 0);
  for (const Side& side : sides_) {
    if (side.turn == 0) continue;
    ++row_end_[row_of(side.low)];
    ++row_end_[row_of(side.high)];
  }
  std::uint32_t begin = 0;
  for (std::uint32_t& end : row_end_)
    begin += std::exchange(end, begin);  // for now, the row's beginning
  for (std::uint32_t i = 0; i < sides_.size(); ++i) {
    const Side& side = sides_[i];
    if (side.turn == 0) continue;
    events_[row_end_[row_of(side.low)]++] = {order_of(side.low), i};
    events_[row_end_[row_of(side.high)]++] = {order_of(side.high), i};
  }
  begin = 0;
  for (const std::uint32_t end : row_end_) {
    sort_row(std::span(events_).subspan(begin, end - begin));
    begin = end;
  }
}

void ArrangedSides::sort_row(std::span<Event> row) {
  constexpr std::size_t kFew = 12;
  if (row.size() > kFew) {
    std::sort(row.begin(), row.end(), comes_before);
    return;
  }
  for (std::size_t i = 1; i < row.size(); ++i) {
    const Event event = row[i];
    std::size_t at = i;
    for (; at > 0 && comes_before(event, row[at - 1]); --at)
      row[at] = row[at - 1];
    row[at] = event;
  }
}

void ArrangedSides::queue(Event event) {
  queue_.push_back(event);
  std::push_heap(queue_.begin(), queue_.end(), comes_after);
}

// Collects the sides that begin or end at the next point. False if there is no next point.
bool ArrangedSides::take_events(GridPoint& point) {
  ending_.clear();
  beginning_.clear();
  if (next_event_ == events_.size() && queue_.empty()) return false;
  std::uint64_t order = next_event_ < events_.size() ? events_[next_event_].point : queue_.front().point;
  if (!queue_.empty()) order = std::min(order, queue_.front().point);
  point = point_of(order);
  for (; next_event_ < events_.size() && events_[next_event_].point == order; ++next_event_)
    take(events_[next_event_]);
  while (!queue_.empty() && queue_.front().point == order) {
    take(queue_.front());
    std::pop_heap(queue_.begin(), queue_.end(), comes_after);
    queue_.pop_back();
  }
  return true;
}

void ArrangedSides::take(const Event& event) {
  const Side& side = sides_[event.side];
  if (side.turn == 0) return;  // merged with another side since the event was made
  if (event.point == order_of(side.low)) beginning_.push_back(event.side);
  if (event.point == order_of(side.high)) ending_.push_back(event.side);
}

void ArrangedSides::pass(GridPoint point) {
  if (ending_.empty() && beginning_.empty()) return;
  find_neighbours(point);
  note_cut_loops();
  if (beginning_.size() > 1) {
    sort_beginning();
    merge_beginning();
  }
  exchange_in_order();
  if (right_ != kNone && !beginning_.empty()) untested_.push_back(order_.before(right_));
  untested_.push_back(left_ != kNone ? left_ : order_.first());
  while (!untested_.empty()) {
    const std::uint32_t left = untested_.back();
    untested_.pop_back();
    if (left != kNone && order_.after(left) != kNone) test(left, order_.after(left), point);
  }
}

// Finds the neighbours left and right of the sides that end here. A side that passes so near that it is led
// through the point ends here too.
void ArrangedSides::find_neighbours(GridPoint point) {
  if (ending_.empty()) {
    left_ = order_.last_not_right([&](std::uint32_t side) { return off_line(sides_[side], point) > 0; });
    right_ = left_ != kNone ? order_.after(left_) : order_.first();
  } else {
    left_ = order_.before(ending_.front());
    right_ = order_.after(ending_.front());
  }
  while (meets(left_, point))
    left_ = order_.before(cut_if_it_passes(left_, point));
  while (meets(right_, point))
    right_ = order_.after(cut_if_it_passes(right_, point));
}

bool ArrangedSides::meets(std::uint32_t side, GridPoint point) const {
  if (side == kNone) return false;
  const Side& s = sides_[side];
  if (s.high == point) return true;
  if (point.x < std::min(s.low.x, s.high.x) || point.x > std::max(s.low.x, s.high.x)) return false;
  return 2 * std::abs(off_line(s, point)) <= length_of(s);
}

// Returns the side that is in the order afterwards: the side itself, or its lower part if it was cut.
std::uint32_t ArrangedSides::cut_if_it_passes(std::uint32_t side, GridPoint point) {
  if (sides_[side].high == point) return side;
  if (off_line(sides_[side], point) != 0) bent_ = true;  // perhaps onto another side
  const std::uint32_t low_part = split_off_low_part(side, point);
  ending_.push_back(low_part);
  beginning_.push_back(side);
  return low_part;
}

// Cuts a side in two and returns the lower part, which takes the side's place in the order; the upper part
// keeps the side's number.
std::uint32_t ArrangedSides::split_off_low_part(std::uint32_t side, GridPoint at) {
  const auto low_part = static_cast<std::uint32_t>(sides_.size());
  sides_.push_back(sides_[side]);
  order_.reserve_numbers(sides_.size());
  sides_[low_part].high = at;
  sides_[side].low = at;
  loop_is_cut_[sides_[side].loop] = 1;
  order_.replace(side, low_part);
  return low_part;
}

// Marks the loops of the sides here as cut. A loop that meets nothing has exactly two sides at each of its
// corners.
void ArrangedSides::note_cut_loops() {
  bool alone = ending_.size() + beginning_.size() == 2;
  if (alone) {
    const std::uint32_t one = (ending_.empty() ? beginning_ : ending_).front();
    const std::uint32_t other = (beginning_.empty() ? ending_ : beginning_).back();
    alone = sides_[one].loop == sides_[other].loop;
  }
  if (alone) return;
  for (const auto* sides : {&ending_, &beginning_}) {
    for (const std::uint32_t side : *sides)
      loop_is_cut_[sides_[side].loop] = 1;
  }
}

// Sorts the sides that begin here from left to right; of sides that lie on each other, the shorter comes
// first.
void ArrangedSides::sort_beginning() {
  std::sort(beginning_.begin(), beginning_.end(), [this](std::uint32_t a, std::uint32_t b) {
    const std::int64_t left = turn_to_left(sides_[a], sides_[b]);
    if (left != 0) return left < 0;
    const std::uint64_t a_end = order_of(sides_[a].high), b_end = order_of(sides_[b].high);
    return a_end != b_end ? a_end < b_end : a < b;
  });
}

// Merges the overlapping parts of sides that lie on each other.
void ArrangedSides::merge_beginning() {
  std::size_t kept = 0;
  for (std::size_t i = 1; i < beginning_.size(); ++i) {
    Side& one = sides_[beginning_[kept]];
    Side& other = sides_[beginning_[i]];
    if (turn_to_left(one, other) != 0) {
      beginning_[++kept] = beginning_[i];
      continue;
    }
    loop_is_cut_[one.loop] = loop_is_cut_[other.loop] = 1;
    one.turn += other.turn;
    if (one.high == other.high) {
      other.turn = 0;
    } else {
      other.low = one.high;
      queue({order_of(one.high), beginning_[i]});
    }
  }
  beginning_.resize(kept + 1);
  std::erase_if(beginning_, [this](std::uint32_t side) { return sides_[side].turn == 0; });
}

void ArrangedSides::exchange_in_order() {
  std::int32_t winding = left_ == kNone ? 0 : sides_[left_].winding_left - sides_[left_].turn;
  const bool one_for_one = ending_.size() == 1 && beginning_.size() == 1;
  if (one_for_one) {
    order_.replace(ending_.front(), beginning_.front());
  } else {
    for (const std::uint32_t side : ending_)
      order_.erase(side);
  }
  std::uint32_t last = left_;
  for (const std::uint32_t side : beginning_) {
    if (!one_for_one) order_.insert_after(last, side);
    last = side;
    sides_[side].winding_left = winding;
    winding -= sides_[side].turn;
    if (winding < 0) winds_negatively_ = true;
  }
}

// Cuts two neighbours at their crossing if the left one is right of the other further up.
void ArrangedSides::test(std::uint32_t left, std::uint32_t right, GridPoint swept_to) {
  const Side& a = sides_[left];
  const Side& b = sides_[right];
  if (std::max(a.low.x, a.high.x) < std::min(b.low.x, b.high.x) || a.high == b.high) return;
  const bool in_order =
      order_of(a.high) < order_of(b.high) ? off_line(b, a.high) >= 0 : off_line(a, b.high) <= 0;
  if (in_order) return;
  const auto apart = [](const Side& side, const Side& by) {
    const std::int64_t low = off_line(by, side.low), high = off_line(by, side.high);
    return (low <= 0 && high <= 0) || (low >= 0 && high >= 0);
  };
  if (apart(a, b) || apart(b, a)) return exchange(left, right);
  const GridPoint crossing = crossing_of(a, b, swept_to);
  if (order_of(crossing) <= order_of(swept_to)) return exchange(left, right);
  cut_ahead(left, crossing);
  cut_ahead(right, crossing);
}

// Exchanges two neighbours that rounding has put into the wrong order.
void ArrangedSides::exchange(std::uint32_t left, std::uint32_t right) {
  bent_ = true;
  order_.erase(left);
  order_.insert_after(right, left);
  untested_.push_back(order_.before(right));
  untested_.push_back(left);
}

// Cuts a side at a point that has not been swept yet. If the point comes after the side's high end (they are
// on one level), the part between them runs the other way.
void ArrangedSides::cut_ahead(std::uint32_t side, GridPoint at) {
  if (at == sides_[side].low || at == sides_[side].high) return;
  const std::uint32_t low_part = split_off_low_part(side, at);
  std::ranges::replace(untested_, side, low_part);
  Side& rest = sides_[side];
  if (order_of(rest.low) > order_of(rest.high)) {
    std::swap(rest.low, rest.high);
    rest.turn = -rest.turn;
  }
  queue({order_of(at), low_part});
  queue({order_of(at), side});
}

}  // namespace contourd
