// Closes what a cracked model leaves open: joins the ends of open chains, nearest first, until every chain is
// part of a closed loop. Ends within the tolerance meet; what is left after that is closed all the same, as a
// guess. Not thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "core/facet.hpp"
#include "core/units.hpp"

namespace contourd {

struct JoinedChains {
  struct Link {
    std::uint32_t chain;  // in the order of OpenChainJoiner::add
    bool reversed;        // to be walked from its end to its start (a turned facet)
  };
  struct Loop {
    std::uint32_t first, count;  // in `links`
    bool repaired;               // at least one of its joins is wider than the tolerance
  };
  std::vector<Link> links;
  std::vector<Loop> loops;
  std::uint32_t open_chains = 0;  // chains left (after merging) when only joins within the tolerance are made
  std::uint32_t gaps_closed = 0;  // joins within the tolerance over more than nothing
  Millimeters widest_gap{};
};

// Keeps its working memory between calls: allocates only while the chains grow in number.
class OpenChainJoiner {
 public:
  // Forgets all chains.
  void reset(Millimeters tolerance);

  // `weight`: among chains that disagree about a loop's direction, the heaviest decides.
  void add(Point start, Point end, std::uint32_t weight);

  // Valid until the next reset().
  [[nodiscard]] const JoinedChains& join();

 private:
  // End 2i is chain i's start, 2i + 1 its end.
  struct Pair {
    double cost, gap;
    std::uint32_t a, b;
  };
  // A square of the tolerance's size, by row and column, and an end in it.
  struct Cell {
    double row, column;
    std::uint32_t end;
  };

  [[nodiscard]] Pair pair_of(std::uint32_t a, std::uint32_t b, double reversal_cost) const;
  void join_within_tolerance();
  void add_neighbors(const Cell& cell, std::vector<Cell>::const_iterator other, double row,
                     double last_column);
  void join_what_is_left();
  void make_pairs();
  void collect_loops();

  double tolerance_mm_ = 0;
  std::vector<Point> ends_;
  std::vector<std::uint32_t> weights_;
  std::vector<std::uint32_t> partner_;  // by end
  std::vector<bool> guessed_;           // by end: its join is wider than the tolerance
  std::vector<Cell> cells_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> left_;            // ends without a partner
  std::vector<std::uint32_t> heaviest_first_;  // chains
  std::vector<bool> done_;                     // by chain
  JoinedChains joined_;
};

}  // namespace contourd
