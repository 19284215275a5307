#include "core/open_chain_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace contourd {
namespace {

constexpr std::uint32_t kFree = 0xFFFFFFFF;

// The last round reaches 2^12 times the tolerance: 20 cm at a pixel of 50 um.
constexpr int kRounds = 13;

// Beyond this many ends left over after that, each chain is closed on itself: weighing all pairs costs the
// square of it.
constexpr std::size_t kMostEndsToPair = 1024;

// Of the ends in a row of cells around an end so many are weighed when the nearest are joined and when ends
// are paired anew; so many in one search, and so many in all of a section's: a soup of facets must not take
// seconds.
constexpr int kMostNeighbors = 64;
constexpr int kMostSearchNeighbors = 400;
constexpr int kMostSearchLooks = 20'000;
constexpr int kMostLooks = 4'000'000;

// A join this much narrower than a round's reach is beyond doubt, and not given up for a wider one.
constexpr double kSureFactor = 1.0 / 64;

// Joining two starts or two ends means that one of the chains runs against its facets' winding: only where
// nothing four times as far fits in the right direction (up to eight times, as the rounds' reaches lie).
constexpr double kTurnedFactor = 1.0 / 4;

// A segment is alone when nothing eight times as far as its length is left to meet.
constexpr double kAloneFactor = 1.0 / 8;

bool is_start(std::uint32_t end) {
  return end % 2 == 0;
}

}  // namespace

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

const JoinedChains& OpenChainJoiner::join() {
  partner_.assign(ends_.size(), kFree);
  seen_in_.assign(ends_.size(), 0);
  came_from_.assign(ends_.size(), kFree);
  searches_ = 0;
  looks_ = 0;
  all_.resize(ends_.size());
  std::iota(all_.begin(), all_.end(), 0U);
  find_free_ends();
  double reach = std::max(tolerance_mm_, 1e-9);
  for (int round = 0; round < kRounds && !free_.empty(); ++round, reach *= 2)
    join_within(reach);
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

void OpenChainJoiner::join_within(double reach) {
  join_nearest(reach);
  find_free_ends();
  if (free_.empty()) return;
  join_by_pairing_anew(reach);
  find_free_ends();
  if (free_.empty()) return;
  join_turned_chains(reach * kTurnedFactor);
  find_free_ends();
}

void OpenChainJoiner::join_nearest(double reach) {
  nearby_.sort(ends_, free_, reach);
  pairs_.clear();
  for (const std::uint32_t end : free_) {
    if (is_start(end)) continue;
    nearby_.visit_near(ends_[end], kMostNeighbors, [&](std::uint32_t start) {
      const double gap = may_meet(end, start, reach) ? gap_between(end, start) : reach * 2;
      if (gap <= reach) pairs_.push_back({gap, end, start});
      return true;
    });
  }
  make_pairs();
}

// Every end that is still free looks for a start that is, by way of others that change their partners.
void OpenChainJoiner::join_by_pairing_anew(double reach) {
  nearby_.sort(ends_, all_, reach);
  for (const std::uint32_t end : free_) {
    if (!is_start(end)) pair_anew(end, reach);
  }
}

bool OpenChainJoiner::pair_anew(std::uint32_t end, double reach) {
  ++searches_;
  queue_.assign(1, {0, end, kFree});
  // The cheapest way first, by what its new joins are wider than those that they replace. A way that costs
  // more than a join across the round's reach is left to the next round, where that join may be.
  const auto dearer = [](const Step& a, const Step& b) {
    return std::tie(a.cost, a.end, a.start) > std::tie(b.cost, b.end, b.start);
  };
  const int most_looks = std::min(looks_ + kMostSearchLooks, kMostLooks);
  while (!queue_.empty() && looks_ < most_looks) {
    std::pop_heap(queue_.begin(), queue_.end(), dearer);
    const Step step = queue_.back();
    queue_.pop_back();
    std::uint32_t from = end;
    if (step.start != kFree) {
      if (seen_in_[step.start] == searches_) continue;
      seen_in_[step.start] = searches_;
      came_from_[step.start] = step.end;
      if (partner_[step.start] == kFree) {
        take_way_to(step.start);
        return true;
      }
      from = partner_[step.start];
    }
    nearby_.visit_near(ends_[from], kMostSearchNeighbors, [&](std::uint32_t start) {
      ++looks_;
      if (!may_meet(from, start, reach) || seen_in_[start] == searches_) return true;
      const double gap = gap_between(from, start);
      if (step.cost + gap > reach) return true;
      double saved = 0;
      if (partner_[start] != kFree) {
        saved = gap_between(partner_[start], start);
        // A start that has been joined to a start belongs to a turned chain, and stays.
        if (is_start(partner_[start]) || saved < reach * kSureFactor) return true;
      }
      queue_.push_back({step.cost + std::max(gap - saved, 0.0), from, start});
      std::push_heap(queue_.begin(), queue_.end(), dearer);
      return true;
    });
  }
  return false;
}

// A single segment closed on itself encloses nothing, and is missing elsewhere: only when nothing else is
// near.
bool OpenChainJoiner::may_meet(std::uint32_t end, std::uint32_t start, double reach) const {
  if (!is_start(start)) return false;
  const bool single_segment = start == (end ^ 1U) && weights_[end / 2] <= 2;
  return !single_segment || gap_between(end, start) <= reach * kAloneFactor;
}

void OpenChainJoiner::take_way_to(std::uint32_t start) {
  while (start != kFree) {
    const std::uint32_t end = came_from_[start];
    const std::uint32_t given_up = partner_[end];
    join_ends(end, start);
    start = given_up;
  }
}

// A chain of turned facets has a start where a start is, and an end where an end is: both at once, or it is
// not one.
void OpenChainJoiner::join_turned_chains(double reach) {
  nearby_.sort(ends_, free_, reach);
  for (const std::uint32_t start : free_) {
    if (!is_start(start) || partner_[start] != kFree) continue;
    const std::uint32_t other = free_end_like(start, reach);
    if (other == kFree) continue;
    for (const std::uint32_t turned : {start, other}) {
      const std::uint32_t far = far_end_of(turned);
      const std::uint32_t met = is_start(far) ? kFree : free_end_like(far, reach);
      if (met == kFree) continue;
      join_ends(start, other);
      join_ends(far, met);
      break;
    }
  }
}

// The nearest other free end of the same kind within the reach.
std::uint32_t OpenChainJoiner::free_end_like(std::uint32_t end, double reach) const {
  std::uint32_t nearest = kFree;
  double least = reach;
  nearby_.visit_near(ends_[end], kMostNeighbors, [&](std::uint32_t other) {
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

// The free end at the other side of the chain that joins have made.
std::uint32_t OpenChainJoiner::far_end_of(std::uint32_t end) const {
  std::uint32_t far = end ^ 1U;
  while (partner_[far] != kFree)
    far = partner_[far] ^ 1U;
  return far;
}

void OpenChainJoiner::join_what_is_left() {
  pairs_.clear();
  if (free_.size() <= kMostEndsToPair) {
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
    return std::tie(a.gap, a.a, a.b) < std::tie(b.gap, b.a, b.b);
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
    } else if (gap > 0.0) {
      ++cracks.gaps_closed;
    }
    cracks.widest_gap = std::max(cracks.widest_gap, Millimeters{gap});
  }
}

}  // namespace contourd
