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

// An end is weighed against at most this many neighbours within the tolerance: a soup of coinciding points
// must not cost the square of its size.
constexpr int kMostNeighbors = 16;

// Joining two starts or two ends means that one of the chains runs against its facets' winding: only where
// nothing four times as far fits in the right direction.
constexpr double kReversalFactor = 4.0;

struct Cell {
  double row, column;
  std::uint32_t end;
};

}  // namespace

void OpenChainJoiner::add(Point start, Point end, std::uint32_t weight) {
  ends_.push_back(start);
  ends_.push_back(end);
  weights_.push_back(weight);
}

JoinedChains OpenChainJoiner::join() {
  JoinedChains joined;
  partner_.assign(ends_.size(), kFree);
  guessed_.assign(ends_.size(), false);
  join_within_tolerance(joined);
  const auto free_ends = static_cast<std::uint32_t>(std::count(partner_.begin(), partner_.end(), kFree));
  joined.open_chains = free_ends / 2;
  if (free_ends > 0) join_what_is_left(joined);
  collect_loops(joined);
  return joined;
}

OpenChainJoiner::Pair OpenChainJoiner::pair_of(std::uint32_t a, std::uint32_t b, double reversal_cost) const {
  const double gap = std::hypot(ends_[a].x - ends_[b].x, ends_[a].y - ends_[b].y);
  const bool reversal = a % 2 == b % 2;
  return {reversal ? reversal_cost + gap * kReversalFactor : gap, gap, a, b};
}

void OpenChainJoiner::join_within_tolerance(JoinedChains& joined) {
  // Ends sorted into square cells of the tolerance's size, row by row: neighbours lie in three runs of three
  // cells.
  const double cell_mm = std::max(tolerance_mm_, 1e-9);
  std::vector<Cell> cells(ends_.size());
  for (std::uint32_t i = 0; i < ends_.size(); ++i) {
    cells[i] = {std::floor(ends_[i].y / cell_mm), std::floor(ends_[i].x / cell_mm), i};
  }
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) {
    return std::tie(a.row, a.column, a.end) < std::tie(b.row, b.column, b.end);
  });
  std::vector<Pair> pairs;
  for (const Cell& cell : cells) {
    for (const double row : {cell.row - 1, cell.row, cell.row + 1}) {
      auto other = std::lower_bound(cells.begin(), cells.end(), cell, [row](const Cell& a, const Cell& b) {
        return a.row != row ? a.row < row : a.column < b.column - 1;
      });
      int neighbors = 0;
      for (; other != cells.end() && other->row == row && other->column <= cell.column + 1; ++other) {
        if (other->end <= cell.end) continue;
        const Pair pair = pair_of(cell.end, other->end, tolerance_mm_);
        if (pair.gap > tolerance_mm_) continue;
        pairs.push_back(pair);
        if (++neighbors == kMostNeighbors) break;
      }
    }
  }
  make_pairs(pairs, joined);
}

void OpenChainJoiner::join_what_is_left(JoinedChains& joined) {
  std::vector<std::uint32_t> left;
  for (std::uint32_t end = 0; end < ends_.size(); ++end) {
    if (partner_[end] == kFree) left.push_back(end);
  }
  for (const std::uint32_t end : left)
    guessed_[end] = true;
  std::vector<Pair> pairs;
  if (left.size() <= kMostEndsToPair) {
    for (std::size_t i = 0; i < left.size(); ++i) {
      for (std::size_t j = i + 1; j < left.size(); ++j)
        pairs.push_back(pair_of(left[i], left[j], 0.0));
    }
  } else {
    // Each merged chain on itself: from a free end through its joins to the free end at the other side.
    for (const std::uint32_t start : left) {
      std::uint32_t end = start ^ 1U;
      while (partner_[end] != kFree)
        end = partner_[end] ^ 1U;
      if (start < end) pairs.push_back(pair_of(start, end, 0.0));
    }
  }
  make_pairs(pairs, joined);
}

void OpenChainJoiner::make_pairs(std::vector<Pair>& pairs, JoinedChains& joined) {
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(a.cost, a.a, a.b) < std::tie(b.cost, b.a, b.b);
  });
  for (const Pair& pair : pairs) {
    if (partner_[pair.a] != kFree || partner_[pair.b] != kFree) continue;
    partner_[pair.a] = pair.b;
    partner_[pair.b] = pair.a;
    if (pair.gap > 0.0 && !guessed_[pair.a]) ++joined.gaps_closed;
    joined.widest_gap = std::max(joined.widest_gap, Millimeters{pair.gap});
  }
}

void OpenChainJoiner::collect_loops(JoinedChains& joined) const {
  std::vector<std::uint32_t> heaviest_first(weights_.size());
  std::iota(heaviest_first.begin(), heaviest_first.end(), 0U);
  std::stable_sort(heaviest_first.begin(), heaviest_first.end(),
                   [this](std::uint32_t a, std::uint32_t b) { return weights_[a] > weights_[b]; });
  std::vector<bool> done(weights_.size(), false);
  for (const std::uint32_t first : heaviest_first) {
    if (done[first]) continue;
    JoinedChains::Loop loop{static_cast<std::uint32_t>(joined.links.size()), 0, false};
    std::uint32_t entered_at = 2 * first;  // by its start: not reversed
    do {
      const std::uint32_t chain = entered_at / 2;
      const std::uint32_t left_at = entered_at ^ 1U;
      done[chain] = true;
      joined.links.push_back({chain, entered_at % 2 == 1});
      loop.repaired = loop.repaired || guessed_[left_at];
      ++loop.count;
      entered_at = partner_[left_at];
    } while (entered_at != 2 * first);
    joined.loops.push_back(loop);
  }
}

}  // namespace contourd
