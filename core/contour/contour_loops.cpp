#include "core/contour/contour_loops.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/geometry/point_hash.hpp"

namespace contourd {
namespace {

// Returns how far `leaving` turns to the left from `arriving`, in (-2, 2): 0 straight on, 1 a right angle to
// the left. Straight back is -2, the last resort: walls of touching solids run back over each other.
// (Monotonic in the angle, and without trigonometry, which differs between C libraries.)
double left_turn(const Segment& arriving, const Segment& leaving) {
  const double ax = arriving.to.x - arriving.from.x, ay = arriving.to.y - arriving.from.y;
  const double bx = leaving.to.x - leaving.from.x, by = leaving.to.y - leaving.from.y;
  const double dot = ax * bx + ay * by;
  const double cross = ax * by - ay * bx;
  const double off_straight = 1.0 - dot / (std::fabs(dot) + std::fabs(cross));
  return cross > 0.0 || off_straight == 0.0 ? off_straight : -off_straight;
}

// True if a chain that was closed on itself is a sheet within a solid (an internal wall of one side) and not
// the rest of a hole's contour: it runs clockwise, and its open distance is more than half its length.
// Closed, it would cut a hole between itself and the straight line.
bool is_sheet(std::span<const Point> chain) {
  double twice_area = 0, length = 0;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const double ax = chain[i].x - chain[0].x, ay = chain[i].y - chain[0].y;
    const double bx = chain[i + 1].x - chain[0].x, by = chain[i + 1].y - chain[0].y;
    twice_area += ax * by - bx * ay;
    length += std::hypot(bx - ax, by - ay);
  }
  const Point& first = chain.front();
  const Point& last = chain.back();
  return twice_area < 0 && std::hypot(last.x - first.x, last.y - first.y) > length / 2;
}

// Limit on segments looked at for doubled ones, per segment of the section: a soup of segments must not take
// seconds.
constexpr std::size_t kMaxLooksASegment = 64;

}  // namespace

double perimeter_mm(const Contours& contours) {
  double sum = 0;
  for (const ContourLoop& loop : contours.loops) {
    const std::span<const Point> points = contours.points_of(loop);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Point& a = points[i];
      const Point& b = points[i + 1 < points.size() ? i + 1 : 0];
      sum += std::hypot(b.x - a.x, b.y - a.y);
    }
  }
  return sum;
}

void ContourLinker::clear(Contours& contours) {
  contours.points.clear();
  contours.loops.clear();
  contours.cracks = LayerCracks{};
  contours.repaired_loops = 0;
}

void ContourLinker::link(std::span<const Segment> segments, Millimeters tolerance, Contours& contours) {
  MaskBudget unlimited;
  link(segments, tolerance, contours, unlimited);
}

void ContourLinker::link(std::span<const Segment> segments, Millimeters tolerance, Contours& contours,
                         MaskBudget& budget) {
  clear(contours);
  if (link_simple(segments, contours)) return;
  clear(contours);
  find_ends(segments);
  walk_chains(segments, contours);
  walk_loops(segments, contours);
  join_chains(tolerance, contours, budget);
}

void ContourLinker::close_open_chains(std::vector<Segment>& segments, Millimeters tolerance,
                                      Contours& contours, MaskBudget& budget) {
  clear(contours);
  find_ends(segments);
  walk_chains(segments, contours);
  join_chains(tolerance, contours, budget);
  for (std::size_t i = segments.size(); i-- > 0;) {
    if (used_[i] == 0) continue;
    segments[i] = segments.back();
    segments.pop_back();
  }
}

// Links a section in which one segment starts and one ends at every point, as in most sections. False for
// any other section; `contours` is then of no use.
bool ContourLinker::link_simple(std::span<const Segment> segments, Contours& contours) {
  const auto count = static_cast<std::uint32_t>(segments.size());
  slots_.assign(std::bit_ceil(std::size_t{count} * 2 + 1), kNone);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t& slot = slot_of(segments[i].from, segments);
    if (slot != kNone) return false;
    slot = i;
  }
  next_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    next_[i] = slot_of(segments[i].to, segments);
    if (next_[i] == kNone) return false;
  }
  for (std::uint32_t first = 0; first < count; ++first) {
    if (next_[first] == kNone) continue;
    const auto first_point = static_cast<std::uint32_t>(contours.points.size());
    std::uint32_t i = first;
    do {
      contours.points.push_back(segments[i].from);
      i = std::exchange(next_[i], kNone);
    } while (next_[i] != kNone);
    if (i != first) return false;  // two segments end at one point
    contours.loops.push_back({first_point, static_cast<std::uint32_t>(contours.points.size()) - first_point});
  }
  return true;
}

// Returns the slot of the segment that starts at this point, or the free slot where it would be.
std::uint32_t& ContourLinker::slot_of(const Point& point, std::span<const Segment> segments) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_of(point) & mask;
  while (slots_[slot] != kNone && !(segments[slots_[slot]].from == point))
    slot = (slot + 1) & mask;
  return slots_[slot];
}

void ContourLinker::find_ends(std::span<const Segment> segments) {
  ends_.reset(segments);
  used_.assign(segments.size(), 0);
}

void ContourLinker::walk_chains(std::span<const Segment> segments, Contours& contours) {
  chain_points_.clear();
  chains_.clear();
  drop_duplicates(segments);
  for (UnbalancedPoint* const start : ends_.starts())
    walk_chains_from(*start, segments, contours);
}

// Drops runs of doubled segments. A facet that is in the file twice gives the same segment twice;
// neighbouring duplicates form a run. A run is dropped once if it leaves both of its end points unbalanced.
// Where two solids share a wall the points are balanced, and the run stays.
void ContourLinker::drop_duplicates(std::span<const Segment> segments) {
  looks_left_ = kMaxLooksASegment * segments.size();
  for (UnbalancedPoint* const start : ends_.starts()) {
    std::uint32_t i = ends_.first_leaving(start->point);
    for (; i != kNone && start->leaving_minus_arriving > 0; i = ends_.next_leaving(i)) {
      if (is_doubled(i, segments) && drop_run(i, segments)) --start->leaving_minus_arriving;
    }
  }
}

// True if another segment leads from the same point to the same point and both are unused.
bool ContourLinker::is_doubled(std::uint32_t segment, std::span<const Segment> segments) {
  if (used_[segment] != 0) return false;
  const Segment& s = segments[segment];
  std::uint32_t i = ends_.first_leaving(s.from);
  for (; i != kNone && looks_left_ > 0; i = ends_.next_leaving(i), --looks_left_) {
    if (i != segment && used_[i] == 0 && segments[i].to == s.to) return true;
  }
  return false;
}

// Follows doubled segments to a point that more segments reach than leave, and drops them, which balances
// both points. Drops nothing if there is no such point.
bool ContourLinker::drop_run(std::uint32_t first, std::span<const Segment> segments) {
  run_.clear();
  for (std::uint32_t i = first; i != kNone;) {
    used_[i] = 1;
    run_.push_back(i);
    const Point& here = segments[i].to;
    UnbalancedPoint* const end = ends_.unbalanced_at(here);
    if (end != nullptr && end->leaving_minus_arriving < 0) {
      ++end->leaving_minus_arriving;
      return true;
    }
    i = ends_.first_leaving(here);
    while (i != kNone && !is_doubled(i, segments))
      i = ends_.next_leaving(i);
  }
  for (const std::uint32_t i : run_)
    used_[i] = 0;
  return false;
}

// Starts one chain for each segment that leaves the point in surplus.
void ContourLinker::walk_chains_from(UnbalancedPoint& start, std::span<const Segment> segments,
                                     Contours& contours) {
  std::uint32_t i = ends_.first_leaving(start.point);
  for (; i != kNone && start.leaving_minus_arriving > 0; i = ends_.next_leaving(i)) {
    if (used_[i] != 0) continue;
    const auto first_point = static_cast<std::uint32_t>(chain_points_.size());
    // A walk that comes back to its start took a loop along; the surplus is still there.
    if (walk(i, segments, chain_points_)) {
      const auto begin = chain_points_.begin() + first_point;
      const auto loop_point = static_cast<std::uint32_t>(contours.points.size());
      contours.points.insert(contours.points.end(), begin, chain_points_.end());
      contours.loops.push_back({loop_point, static_cast<std::uint32_t>(chain_points_.end() - begin)});
      chain_points_.erase(begin, chain_points_.end());
    } else {
      --start.leaving_minus_arriving;
      chains_.push_back({first_point, static_cast<std::uint32_t>(chain_points_.size()) - first_point});
    }
  }
}

std::uint32_t ContourLinker::leftmost_leaving(std::uint32_t arrived_by, std::span<const Segment> segments) {
  const Point& here = segments[arrived_by].to;
  std::uint32_t best = kNone;
  double best_turn = 0;
  for (std::uint32_t i = ends_.first_leaving(here); i != kNone; i = ends_.next_leaving(i)) {
    if (used_[i] != 0) continue;
    // Where solids touch at a point or along an edge, the leftmost turn stays on the same solid.
    const bool alone = best == kNone && ends_.next_leaving(i) == kNone;
    const double turn = alone ? 0.0 : left_turn(segments[arrived_by], segments[i]);
    if (best == kNone || turn > best_turn) {
      best = i;
      best_turn = turn;
    }
  }
  return best;
}

bool ContourLinker::walk(std::uint32_t segment, std::span<const Segment> segments,
                         std::vector<Point>& points) {
  const Point start = segments[segment].from;
  while (true) {
    used_[segment] = 1;
    points.push_back(segments[segment].from);
    if (segments[segment].to == start) return true;
    const std::uint32_t next = leftmost_leaving(segment, segments);
    if (next == kNone) {
      points.push_back(segments[segment].to);
      return false;
    }
    segment = next;
  }
}

void ContourLinker::walk_loops(std::span<const Segment> segments, Contours& contours) {
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    if (used_[i] != 0) continue;
    const auto first = static_cast<std::uint32_t>(contours.points.size());
    walk(i, segments, contours.points);
    contours.loops.push_back({first, static_cast<std::uint32_t>(contours.points.size()) - first});
  }
}

void ContourLinker::join_chains(Millimeters tolerance, Contours& contours, MaskBudget& budget) {
  if (chains_.empty()) return;
  joiner_.reset(tolerance);
  for (const Chain& chain : chains_) {
    const Point* points = chain_points_.data() + chain.first_point;
    joiner_.add(points[0], points[chain.point_count - 1], chain.point_count);
  }
  const JoinedChains& joined = joiner_.join(budget);
  contours.cracks = joined.cracks;
  for (const JoinedChains::Loop& loop : joined.loops) {
    const auto first = static_cast<std::uint32_t>(contours.points.size());
    for (std::uint32_t i = 0; i < loop.count; ++i) {
      const JoinedChains::Link& link = joined.links[loop.first + i];
      const auto begin = chain_points_.begin() + chains_[link.chain].first_point;
      const auto end = begin + chains_[link.chain].point_count;
      if (link.reversed) {
        contours.points.insert(contours.points.end(), std::make_reverse_iterator(end),
                               std::make_reverse_iterator(begin));
      } else {
        contours.points.insert(contours.points.end(), begin, end);
      }
    }
    const ContourLoop closed{first, static_cast<std::uint32_t>(contours.points.size()) - first};
    if (loop.repaired && loop.count == 1 && is_sheet(contours.points_of(closed))) {
      contours.points.resize(first);
      continue;
    }
    contours.loops.push_back(closed);
    if (loop.repaired) ++contours.repaired_loops;
  }
}

}  // namespace contourd
