// Closes what a cracked model leaves open: joins the ends of open chains until every chain is part of a
// closed loop. Ends within the tolerance meet; what is left after that is closed all the same, as a guess.
//
// The reach doubles from round to round, beginning with the tolerance. In each round the nearest ends join
// first, and then ends that were left over come to a partner by re-pairing joins on the way, if they can
// within the round's reach. Without that, one wrong choice among crowded ends pushes the next one on, along a
// whole contour, and in the end two ends are left on opposite sides of the part. Not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/facet.hpp"
#include "core/layer_cracks.hpp"
#include "core/nearby_ends.hpp"
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
  LayerCracks cracks;
};

// Keeps its working memory between calls: allocates only while the chains grow in number.
class OpenChainJoiner {
 public:
  // Forgets all chains.
  void reset(Millimeters tolerance);

  // `weight`: how many points the chain has; among chains that disagree about a loop's direction, the
  // heaviest decides.
  void add(Point start, Point end, std::uint32_t weight);

  // Valid until the next reset().
  [[nodiscard]] const JoinedChains& join();

 private:
  // End 2i is chain i's start, 2i + 1 its end.
  struct Pair {
    double gap;
    std::uint32_t a, b;
  };

  // A new join on a search's way, and what the way up to it costs.
  struct Step {
    double cost;
    std::uint32_t end, start;
  };

  [[nodiscard]] bool may_meet(std::uint32_t end, std::uint32_t start, double reach) const;
  [[nodiscard]] double gap_between(std::uint32_t a, std::uint32_t b) const;
  void join_ends(std::uint32_t a, std::uint32_t b);
  void find_free_ends();
  void join_within(double reach);
  void join_nearest(double reach);
  void join_by_pairing_anew(double reach);
  bool pair_anew(std::uint32_t end, double reach);
  void take_way_to(std::uint32_t start);
  void join_turned_chains(double reach);
  [[nodiscard]] std::uint32_t free_end_like(std::uint32_t end, double reach) const;
  [[nodiscard]] std::uint32_t far_end_of(std::uint32_t end) const;
  void join_what_is_left();
  void make_pairs();
  void collect_loops();
  void report();

  double tolerance_mm_ = 0;
  std::vector<Point> ends_;
  std::vector<std::uint32_t> weights_;
  std::vector<std::uint32_t> partner_;  // by end
  std::vector<std::uint32_t> free_;     // ends without a partner
  std::vector<std::uint32_t> all_;
  NearbyEnds nearby_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> seen_in_;    // by start: the search that came to it last
  std::vector<std::uint32_t> came_from_;  // by start: the end that it was reached from
  std::vector<Step> queue_;               // a heap: where a search may go on
  std::uint32_t searches_ = 0;
  int looks_ = 0;                              // at ends, by all searches of a join()
  std::vector<std::uint32_t> heaviest_first_;  // chains
  std::vector<bool> done_;                     // by chain
  JoinedChains joined_;
};

}  // namespace contourd
