#include "core/open_chain_joiner.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace contourd {
namespace {

constexpr std::uint32_t kFree = 0xFFFFFFFF;

// Beyond this many ends left over, each chain is closed on itself: weighing all pairs costs the square of it.
constexpr std::size_t kMostEndsToPair = 1024;

// An end is weighed against at most this many neighbours in its row and in the next: a soup of coinciding
// points must not cost the square of its size.
constexpr int kMostNeighbors = 64;

// Joining two starts or two ends means that one of the chains runs against its facets' winding: only where
// nothing four times as far fits in the right direction.
constexpr double kReversalFactor = 4.0;

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
  joined_.links.clear();
  joined_.loops.clear();
  joined_.gaps_closed = 0;
  joined_.widest_gap = Millimeters{};
  partner_.assign(ends_.size(), kFree);
  guessed_.assign(ends_.size(), false);
  join_within_tolerance();
  const auto free_ends = static_cast<std::uint32_t>(std::count(partner_.begin(), partner_.end(), kFree));
  joined_.open_chains = free_ends / 2;
  if (free_ends > 0) join_what_is_left();
  collect_loops();
  return joined_;
}

OpenChainJoiner::Pair OpenChainJoiner::pair_of(std::uint32_t a, std::uint32_t b, double reversal_cost) const {
  // Not std::hypot, which differs between C libraries. Coordinates are floats' size: squares do not overflow.
  const double dx = ends_[a].x - ends_[b].x, dy = ends_[a].y - ends_[b].y;
  const double gap = std::sqrt(dx * dx + dy * dy);
  const bool reversal = a % 2 == b % 2;
  return {reversal ? reversal_cost + gap * kReversalFactor : gap, gap, a, b};
}

void OpenChainJoiner::join_within_tolerance() {
  // Ends sorted into square cells of the tolerance's size, row by row: a cell's neighbours lie in three
  // runs of three.
  const double cell_mm = std::max(tolerance_mm_, 1e-9);
  cells_.resize(ends_.size());
  pairs_.clear();
  for (std::uint32_t i = 0; i < ends_.size(); ++i) {
    cells_[i] = {std::floor(ends_[i].y / cell_mm), std::floor(ends_[i].x / cell_mm), i};
  }
  std::sort(cells_.begin(), cells_.end(), [](const Cell& a, const Cell& b) {
    return std::tie(a.row, a.column, a.end) < std::tie(b.row, b.column, b.end);
  });
  // Each pair is found from its earlier end: behind it in its own cell and in the next, or in the row above.
  for (auto cell = cells_.begin(); cell != cells_.end(); ++cell) {
    add_neighbors(*cell, cell + 1, cell->row, cell->column + 1);
    const auto above = std::lower_bound(cell, cells_.end(), *cell, [](const Cell& a, const Cell& b) {
      return a.row != b.row + 1 ? a.row < b.row + 1 : a.column < b.column - 1;
    });
    add_neighbors(*cell, above, cell->row + 1, cell->column + 1);
  }
  make_pairs();
}

// Weighs an end against those from `other` on, up to the given column of the row.
void OpenChainJoiner::add_neighbors(const Cell& cell, std::vector<Cell>::const_iterator other, double row,
                                    double last_column) {
  for (int looks = 0; looks < kMostNeighbors && other != cells_.end(); ++looks, ++other) {
    if (other->row != row || other->column > last_column) return;
    const Pair pair = pair_of(cell.end, other->end, tolerance_mm_);
    if (pair.gap <= tolerance_mm_) pairs_.push_back(pair);
  }
}

void OpenChainJoiner::join_what_is_left() {
  left_.clear();
  pairs_.clear();
  for (std::uint32_t end = 0; end < ends_.size(); ++end) {
    if (partner_[end] == kFree) left_.push_back(end);
  }
  for (const std::uint32_t end : left_)
    guessed_[end] = true;
  if (left_.size() <= kMostEndsToPair) {
    for (std::size_t i = 0; i < left_.size(); ++i) {
      for (std::size_t j = i + 1; j < left_.size(); ++j)
        pairs_.push_back(pair_of(left_[i], left_[j], 0.0));
    }
  } else {
    // Each merged chain on itself: from a free end through its joins to the free end at the other side.
    for (const std::uint32_t start : left_) {
      std::uint32_t end = start ^ 1U;
      while (partner_[end] != kFree)
        end = partner_[end] ^ 1U;
      if (start < end) pairs_.push_back(pair_of(start, end, 0.0));
    }
  }
  make_pairs();
}

void OpenChainJoiner::make_pairs() {
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.cost, a.a, a.b) < std::tie(b.cost, b.a, b.b);
  });
  for (const Pair& pair : pairs_) {
    if (partner_[pair.a] != kFree || partner_[pair.b] != kFree) continue;
    partner_[pair.a] = pair.b;
    partner_[pair.b] = pair.a;
    if (pair.gap > 0.0 && !guessed_[pair.a]) ++joined_.gaps_closed;
    joined_.widest_gap = std::max(joined_.widest_gap, Millimeters{pair.gap});
  }
}

void OpenChainJoiner::collect_loops() {
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
      loop.repaired = loop.repaired || guessed_[left_at];
      ++loop.count;
      entered_at = partner_[left_at];
    } while (entered_at != 2 * first);
    joined_.loops.push_back(loop);
  }
}

}  // namespace contourd
