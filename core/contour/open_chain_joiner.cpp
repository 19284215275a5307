#include "core/contour/open_chain_joiner.hpp"

#include <cmath>
#include <numeric>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::uint32_t kFree = 0xFFFFFFFF;

// The last round reaches 2^12 times the tolerance: 20 cm at a pixel of 50 um.
constexpr int kRounds = 13;

// If more ends than this are left over after that, each chain is closed on itself: the cost of weighing all
// pairs grows with the square of their number.
constexpr std::size_t kMaxEndsToPair = 1024;

// Limits on the starts that are weighed: in a row of cells around an end, in one search, and for a whole
// section: a soup of facets must not take seconds.
constexpr int kMaxNeighbors = 400;
constexpr int kMaxSearchLooks = 1'000'000;
constexpr int kMaxLooks = 8'000'000;

// Once ends look at more starts than this on average, ends with a partner look no farther for another one. If
// no more starts than the second limit are free, an end finds them at any distance.
constexpr int kMaxLooksAnEnd = 100;
constexpr std::size_t kMaxFreeStarts = 64;

// Joining two starts or two ends means that one of the chains runs against its facets' winding. It is only
// done if nothing up to four times as far away fits in the right direction (up to eight times, because of the
// rounds' reaches).
constexpr double kTurnedFactor = 1.0 / 4;

// A single segment is closed on itself only if there is nothing to join it to within eight times its length.
constexpr double kAloneFactor = 8;

// The steps that a search for the nearest free end counts as in a budget.
constexpr std::size_t kStepsOfASearch = 16;

bool is_start(std::uint32_t end) {
  return end % 2 == 0;
}

}  // namespace

PointGrid::Cell PointGrid::cell_of(const Point& point, std::uint32_t number) const {
  return {std::floor(point.y / cell_mm_), std::floor(point.x / cell_mm_), number};
}

void PointGrid::sort(std::span<const Point> points, std::span<const std::uint32_t> chosen, double reach) {
  expects(reach > 0, "the reach is positive");
  cell_mm_ = reach;
  cells_.clear();
  for (const std::uint32_t number : chosen)
    cells_.push_back(cell_of(points[number], number));
  std::sort(cells_.begin(), cells_.end());
}

void OpenChainJoiner::reset(Millimeters tolerance) {
  tolerance_mm_ = tolerance.count();
  ends_.clear();
  weights_.clear();
}

void OpenChainJoiner::add(Point start, Point end, std::uint32_t weight) {
  ends_.push_back(start);
  ends_.push_back(end);
  weights_.push_back(weight);
}

const JoinedChains& OpenChainJoiner::join(MaskBudget& budget) {
  partner_.assign(ends_.size(), kFree);
  reached_in_.assign(ends_.size(), 0);
  predecessor_.assign(ends_.size(), kFree);
  relaxed_in_.assign(ends_.size(), 0);
  relaxation_ = 0;
  path_cost_.assign(ends_.size(), 0);
  potential_.assign(ends_.size(), 0);
  searches_ = 0;
  looks_ = 0;
  starts_.clear();
  for (std::uint32_t chain = 0; chain < weights_.size(); ++chain)
    starts_.push_back(2 * chain);
  find_free_ends();
  double reach = std::max(tolerance_mm_, 1e-9);
  reassignment_reach_ = reach;
  join_turned_runs(reach, budget);
  find_free_ends();
  for (int round = 0; round < kRounds && !free_.empty() && !budget.overrun(); ++round, reach *= 2)
    join_within(reach, budget);
  if (!free_.empty()) join_what_is_left();
  collect_loops();
  report();
  return joined_;
}

double OpenChainJoiner::gap_between(std::uint32_t a, std::uint32_t b) const {
  // Not std::hypot, which differs between C libraries. Coordinates are floats' size: squares do not overflow.
  const double dx = ends_[a].x - ends_[b].x, dy = ends_[a].y - ends_[b].y;
  return std::sqrt(dx * dx + dy * dy);
}

// Returns the cost of a join. A single segment closed on itself encloses nothing and is missing elsewhere, so
// this is a last resort.
double OpenChainJoiner::cost_of(std::uint32_t end, std::uint32_t start) const {
  const bool single_segment = start == (end ^ 1U) && weights_[end / 2] <= 2;
  return gap_between(end, start) * (single_segment ? kAloneFactor : 1.0);
}

void OpenChainJoiner::join_ends(std::uint32_t a, std::uint32_t b) {
  partner_[a] = b;
  partner_[b] = a;
}

void OpenChainJoiner::find_free_ends() {
  free_.clear();
  for (std::uint32_t end = 0; end < ends_.size(); ++end) {
    if (partner_[end] == kFree) free_.push_back(end);
  }
}

void OpenChainJoiner::join_within(double reach, MaskBudget& budget) {
  assign_ends(reach, budget);
  find_free_ends();
  if (free_.empty()) return;
  join_turned_runs(reach, budget);
  find_free_ends();
  join_turned_chains(reach * kTurnedFactor, budget);
  find_free_ends();
}

// Solves the assignment problem between ends and starts: the sum of all joins' costs is the least, where an
// end that stays free costs the reach. By successive shortest augmenting paths with potentials (the Hungarian
// method, on the pairs within the reach). The assignments of earlier rounds are optimal for their reach, and
// their potentials feasible: wider joins could not improve them.
void OpenChainJoiner::assign_ends(double reach, MaskBudget& budget) {
  end_grid_.sort(ends_, starts_, reassignment_reach_);
  free_starts_.clear();
  for (const std::uint32_t end : free_) {
    if (is_start(end)) free_starts_.push_back(end);
  }
  const int looks_before = looks_;
  int relaxations = 0;
  for (const std::uint32_t end : free_) {
    if (is_start(end)) continue;
    const int looks_before_search = looks_;
    augment_from(end, reach);
    if (!budget.spend(static_cast<std::size_t>(looks_ - looks_before_search))) return;
    relaxations += 1 + static_cast<int>(settled_.size());
  }
  if (looks_ - looks_before < kMaxLooksAnEnd * relaxations) reassignment_reach_ = reach * 2;
}

// Adds this end to the assignment: along the shortest path to a free start, or to a start whose end is left
// free, or not at all. The ends on the path change to other starts.
void OpenChainJoiner::augment_from(std::uint32_t end, double reach) {
  ++searches_;
  queue_.clear();
  settled_.clear();
  const int most_looks = std::min(looks_ + kMaxSearchLooks, kMaxLooks);
  double least = reach - potential_[end];
  std::uint32_t last = kFree;  // the start where the path ends
  relax_from(end, 0, least);
  while (!queue_.empty() && looks_ < most_looks) {
    std::pop_heap(queue_.begin(), queue_.end(), heap_order);
    const Step step = queue_.back();
    queue_.pop_back();
    if (step.cost >= least) break;
    if (step.cost > path_cost_[step.start]) continue;
    const std::uint32_t from = partner_[step.start];
    if (from == kFree) {
      least = step.cost;
      last = step.start;
      break;
    }
    settled_.push_back(step.start);
    const double cost_if_left_free = step.cost + reach - potential_[from];
    if (cost_if_left_free < least) {
      least = cost_if_left_free;
      last = step.start;
    }
    relax_from(from, step.cost, least);
  }
  if (looks_ >= most_looks) return;
  potential_[end] += least;
  for (const std::uint32_t start : settled_) {
    const double less = least - path_cost_[start];
    if (less <= 0) continue;
    potential_[start] -= less;
    potential_[partner_[start]] += less;
  }
  if (last != kFree) flip_augmenting_path(last);
}

void OpenChainJoiner::relax_from(std::uint32_t end, double path_cost, double least) {
  ++relaxation_;
  const auto relax = [&](std::uint32_t start) {
    if (relaxed_in_[start] == relaxation_) return;
    relaxed_in_[start] = relaxation_;
    ++looks_;
    if (partner_[start] != kFree && is_start(partner_[start])) return;
    // Rounding must not take the cost below zero: Dijkstra's search needs reduced costs of at least 0.
    const double more = cost_of(end, start) - potential_[end] - potential_[start];
    const double cost = path_cost + std::max(more, 0.0);
    if (cost >= least || (reached_in_[start] == searches_ && cost >= path_cost_[start])) return;
    reached_in_[start] = searches_;
    path_cost_[start] = cost;
    predecessor_[start] = end;
    queue_.push_back({cost, start});
    std::push_heap(queue_.begin(), queue_.end(), heap_order);
  };
  end_grid_.visit_near(ends_[end], kMaxNeighbors, [&relax](std::uint32_t start) {
    relax(start);
    return true;
  });
  if (free_starts_.size() > kMaxFreeStarts) return;
  for (const std::uint32_t start : free_starts_) {
    if (partner_[start] == kFree) relax(start);
  }
}

void OpenChainJoiner::flip_augmenting_path(std::uint32_t start) {
  if (partner_[start] != kFree) partner_[partner_[start]] = kFree;
  while (start != kFree) {
    const std::uint32_t end = predecessor_[start];
    const std::uint32_t released = partner_[end];
    join_ends(end, start);
    start = released;
  }
}

// Joins runs of turned chains. A run whose start is at exactly the same point as another start, and whose end
// is at that of another end, is turned, or its neighbours are: joining both ends bridges no gap. In a ring of
// turned and correct chains, join_turned_chains could leave two starts here and two ends on the other side of
// the part.
void OpenChainJoiner::join_turned_runs(double reach, MaskBudget& budget) {
  end_grid_.sort(ends_, free_, reach);
  far_end_.resize(ends_.size());
  for (const std::uint32_t end : free_)
    far_end_[end] = far_end_of(end);
  for (const std::uint32_t start : free_) {
    if (!is_start(start) || partner_[start] != kFree) continue;
    if (!budget.spend(kStepsOfASearch)) return;
    const std::uint32_t other = free_end_like(start, 0);
    if (other == kFree) continue;
    for (const std::uint32_t turned : {start, other}) {
      const std::uint32_t far = far_end_[turned];
      // As many starts as ends are joined; otherwise some would find no partner.
      const std::uint32_t met = is_start(far) ? kFree : free_end_like(far, 0);
      if (met == kFree) continue;
      join_runs(start, other);
      join_runs(far, met);
      break;
    }
  }
}

void OpenChainJoiner::join_runs(std::uint32_t a, std::uint32_t b) {
  join_ends(a, b);
  const std::uint32_t far_a = far_end_[a], far_b = far_end_[b];
  far_end_[far_a] = far_b;
  far_end_[far_b] = far_a;
}

// Joins single chains of turned facets: such a chain has a start where a start is, and an end where an end
// is, both at once. Chains that have been joined already are left alone: the ends that their two ends would
// take may lie far from each other, and would be missing there.
void OpenChainJoiner::join_turned_chains(double reach, MaskBudget& budget) {
  end_grid_.sort(ends_, free_, reach);
  for (const std::uint32_t start : free_) {
    if (!is_start(start) || partner_[start] != kFree) continue;
    if (!budget.spend(kStepsOfASearch)) return;
    const std::uint32_t other = free_end_like(start, reach);
    if (other == kFree) continue;
    for (const std::uint32_t turned : {start, other}) {
      const std::uint32_t far = turned ^ 1U;
      const std::uint32_t met = partner_[far] != kFree ? kFree : free_end_like(far, reach);
      if (met == kFree) continue;
      join_ends(start, other);
      join_ends(far, met);
      break;
    }
  }
}

// Returns the nearest other free end of the same kind within the reach.
std::uint32_t OpenChainJoiner::free_end_like(std::uint32_t end, double reach) const {
  std::uint32_t nearest = kFree;
  double least = reach;
  end_grid_.visit_near(ends_[end], kMaxNeighbors, [&](std::uint32_t other) {
    const bool fits = other != end && is_start(other) == is_start(end) && partner_[other] == kFree;
    if (!fits) return true;
    const double gap = gap_between(end, other);
    if (gap < least || (gap == least && nearest == kFree)) {
      least = gap;
      nearest = other;
    }
    return true;
  });
  return nearest;
}

// Returns the free end at the other side of the joined chains.
std::uint32_t OpenChainJoiner::far_end_of(std::uint32_t end) const {
  std::uint32_t far = end ^ 1U;
  while (partner_[far] != kFree)
    far = partner_[far] ^ 1U;
  return far;
}

void OpenChainJoiner::join_what_is_left() {
  pairs_.clear();
  if (free_.size() <= kMaxEndsToPair) {
    for (const std::uint32_t end : free_) {
      for (const std::uint32_t start : free_) {
        if (!is_start(end) && is_start(start)) pairs_.push_back({gap_between(end, start), end, start});
      }
    }
  } else {
    for (const std::uint32_t end : free_) {
      const std::uint32_t far = far_end_of(end);
      if (end < far) pairs_.push_back({gap_between(end, far), end, far});
    }
  }
  make_pairs();
}

void OpenChainJoiner::make_pairs() {
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.cost, a.a, a.b) < std::tie(b.cost, b.a, b.b);
  });
  for (const Pair& pair : pairs_) {
    if (partner_[pair.a] == kFree && partner_[pair.b] == kFree) join_ends(pair.a, pair.b);
  }
}

void OpenChainJoiner::collect_loops() {
  joined_.links.clear();
  joined_.loops.clear();
  heaviest_first_.resize(weights_.size());
  std::iota(heaviest_first_.begin(), heaviest_first_.end(), 0U);
  std::sort(heaviest_first_.begin(), heaviest_first_.end(), [this](std::uint32_t a, std::uint32_t b) {
    return weights_[a] != weights_[b] ? weights_[a] > weights_[b] : a < b;
  });
  done_.assign(weights_.size(), false);
  for (const std::uint32_t first : heaviest_first_) {
    if (done_[first]) continue;
    JoinedChains::Loop loop{static_cast<std::uint32_t>(joined_.links.size()), 0, false};
    std::uint32_t entered_at = 2 * first;  // by its start: not reversed
    do {
      const std::uint32_t chain = entered_at / 2;
      const std::uint32_t left_at = entered_at ^ 1U;
      done_[chain] = true;
      joined_.links.push_back({chain, entered_at % 2 == 1});
      loop.repaired = loop.repaired || gap_between(left_at, partner_[left_at]) > tolerance_mm_;
      ++loop.count;
      entered_at = partner_[left_at];
    } while (entered_at != 2 * first);
    joined_.loops.push_back(loop);
  }
}

void OpenChainJoiner::report() {
  LayerCracks& cracks = joined_.cracks;
  cracks = LayerCracks{};
  for (std::uint32_t end = 0; end < ends_.size(); ++end) {
    if (partner_[end] < end) continue;
    const double gap = gap_between(end, partner_[end]);
    if (gap > tolerance_mm_) {
      ++cracks.open_chains;
    } else if (gap > LayerCracks::kNoGap.count()) {
      ++cracks.gaps_closed;
    } else {
      continue;
    }
    cracks.widest_gap = std::max(cracks.widest_gap, Millimeters{gap});
  }
  for (const JoinedChains::Link& link : joined_.links)
    cracks.turned_chains += link.reversed ? 1 : 0;
}

}  // namespace contourd
