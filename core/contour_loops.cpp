#include "core/contour_loops.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace contourd {
namespace {

// How far `leaving` turns to the left from `arriving`, in (-2, 2): 0 straight on, 1 a right angle to the
// left. Straight back is -2, the last resort: walls of touching solids run back over each other. (Monotonic
// in the angle, and without trigonometry, which differs between C libraries.)
double left_turn(const Segment& arriving, const Segment& leaving) {
  const double ax = arriving.to.x - arriving.from.x, ay = arriving.to.y - arriving.from.y;
  const double bx = leaving.to.x - leaving.from.x, by = leaving.to.y - leaving.from.y;
  const double dot = ax * bx + ay * by;
  const double cross = ax * by - ay * bx;
  const double off_straight = 1.0 - dot / (std::fabs(dot) + std::fabs(cross));
  return cross > 0.0 || off_straight == 0.0 ? off_straight : -off_straight;
}

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

void ContourLinker::link(std::span<const Segment> segments, Millimeters tolerance, Contours& contours) {
  contours.points.clear();
  contours.loops.clear();
  contours.cracks = LayerCracks{};
  contours.repaired_loops = 0;
  if (link_simple(segments, contours)) return;
  contours.points.clear();
  contours.loops.clear();
  chain_points_.clear();
  chains_.clear();
  build_nodes(segments);
  drop_duplicates(segments);
  walk_chains(segments, contours);
  walk_loops(segments, contours);
  if (!chains_.empty()) join_chains(tolerance, contours);
}

// Most sections: at every point one segment starts and one ends. False when it is otherwise; `contours` then
// holds nothing of use.
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
    if (i != first) return false;  // two segments end in one point
    contours.loops.push_back({first_point, static_cast<std::uint32_t>(contours.points.size()) - first_point});
  }
  return true;
}

// The slot of the segment that starts in this point, or the free one where it would be.
std::uint32_t& ContourLinker::slot_of(const Point& point, std::span<const Segment> segments) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash_of(point) & mask;
  while (slots_[slot] != kNone && !(segments[slots_[slot]].from == point))
    slot = (slot + 1) & mask;
  return slots_[slot];
}

void ContourLinker::build_nodes(std::span<const Segment> segments) {
  const auto count = static_cast<std::uint32_t>(segments.size());
  nodes_.clear();
  // At most two nodes a segment; at most half of the slots taken.
  slots_.assign(std::bit_ceil(std::size_t{count} * 4 + 1), kNone);
  from_node_.resize(count);
  to_node_.resize(count);
  next_leaving_.resize(count);
  used_.assign(count, false);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t from = node_at(segments[i].from);
    const std::uint32_t to = node_at(segments[i].to);
    from_node_[i] = from;
    to_node_[i] = to;
    next_leaving_[i] = nodes_[from].first_leaving;
    nodes_[from].first_leaving = i;
    ++nodes_[from].leaving_minus_arriving;
    --nodes_[to].leaving_minus_arriving;
  }
}

std::uint32_t ContourLinker::node_at(const Point& point) {
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t slot = hash_of(point) & mask;; slot = (slot + 1) & mask) {
    if (slots_[slot] == kNone) {
      slots_[slot] = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back({point});
      return slots_[slot];
    }
    if (nodes_[slots_[slot]].point == point) return slots_[slot];
  }
}

// A facet that is in the file twice gives the same segment twice. The second is dropped where it is one too
// many at both of its ends; where two solids share a wall it is not.
void ContourLinker::drop_duplicates(std::span<const Segment> segments) {
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    Node& from = nodes_[from_node_[i]];
    Node& to = nodes_[to_node_[i]];
    if (from.leaving_minus_arriving <= 0 || to.leaving_minus_arriving >= 0) continue;
    for (std::uint32_t j = from.first_leaving; j != kNone; j = next_leaving_[j]) {
      if (j == i || used_[j] || to_node_[j] != to_node_[i]) continue;
      used_[i] = true;
      --from.leaving_minus_arriving;
      ++to.leaving_minus_arriving;
      break;
    }
  }
}

std::uint32_t ContourLinker::leftmost_leaving(std::uint32_t node, std::uint32_t arrived_by,
                                              std::span<const Segment> segments) const {
  std::uint32_t best = kNone;
  double best_turn = 0;
  for (std::uint32_t i = nodes_[node].first_leaving; i != kNone; i = next_leaving_[i]) {
    if (used_[i]) continue;
    // Where solids touch in a point or along an edge, the leftmost way stays with the same solid.
    const bool alone = best == kNone && next_leaving_[i] == kNone;
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
  const std::uint32_t start = from_node_[segment];
  while (true) {
    used_[segment] = true;
    points.push_back(segments[segment].from);
    const std::uint32_t here = to_node_[segment];
    if (here == start) return true;
    const std::uint32_t next = leftmost_leaving(here, segment, segments);
    if (next == kNone) {
      points.push_back(segments[segment].to);
      return false;
    }
    segment = next;
  }
}

void ContourLinker::walk_chains(std::span<const Segment> segments, Contours& contours) {
  // A point that more segments leave than reach starts as many chains as it has too many.
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    for (std::uint32_t i = nodes_[node].first_leaving; i != kNone; i = next_leaving_[i]) {
      if (nodes_[node].leaving_minus_arriving <= 0) break;
      if (used_[i]) continue;
      const auto first = static_cast<std::uint32_t>(chain_points_.size());
      // A walk that comes back to its start took a loop along; the surplus is still there.
      if (walk(i, segments, chain_points_)) {
        const auto begin = chain_points_.begin() + first;
        const auto first_point = static_cast<std::uint32_t>(contours.points.size());
        contours.points.insert(contours.points.end(), begin, chain_points_.end());
        contours.loops.push_back({first_point, static_cast<std::uint32_t>(chain_points_.end() - begin)});
        chain_points_.erase(begin, chain_points_.end());
      } else {
        --nodes_[node].leaving_minus_arriving;
        chains_.push_back({first, static_cast<std::uint32_t>(chain_points_.size()) - first});
      }
    }
  }
}

void ContourLinker::walk_loops(std::span<const Segment> segments, Contours& contours) {
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    if (used_[i]) continue;
    const auto first = static_cast<std::uint32_t>(contours.points.size());
    walk(i, segments, contours.points);
    contours.loops.push_back({first, static_cast<std::uint32_t>(contours.points.size()) - first});
  }
}

void ContourLinker::join_chains(Millimeters tolerance, Contours& contours) {
  joiner_.reset(tolerance);
  for (const Chain& chain : chains_) {
    const Point* points = chain_points_.data() + chain.first_point;
    joiner_.add(points[0], points[chain.point_count - 1], chain.point_count);
  }
  const JoinedChains& joined = joiner_.join();
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
    contours.loops.push_back({first, static_cast<std::uint32_t>(contours.points.size()) - first});
    if (loop.repaired) ++contours.repaired_loops;
  }
}

}  // namespace contourd
