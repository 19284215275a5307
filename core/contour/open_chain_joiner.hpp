// Closes the contours of a cracked model: joins the ends of open chains until every chain is part of a closed
// loop. Ends within the tolerance are joined; chains that are still open after that are closed all the same,
// as a guess.
//
// Chains that turned facets leave apart, starts at one point and ends at another, are joined first: there is
// no gap.
//
// The reach doubles from round to round, beginning with the tolerance. Each round solves the assignment
// problem between ends and starts: the sum of all gaps is the least, where an end that stays free counts as a
// gap of the reach. Pairing the nearest ends greedily could shift the joins along a whole contour, until two
// ends are left on opposite sides of the part. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "core/contour/layer_cracks.hpp"
#include "core/geometry/facet.hpp"
#include "core/geometry/mask_budget.hpp"
#include "core/geometry/units.hpp"

namespace contourd {

// Keeps its memory between calls: allocates only while the points grow in number.
// A uniform grid of points: finds the points that may lie within a reach of a place. Not thread-safe.
class PointGrid {
 public:
  // Sorts the chosen `points` into square cells of the reach's size, row by row: a cell and its neighbours
  // lie in three runs of three. REQUIRES: reach > 0.
  void sort(std::span<const Point> points, std::span<const std::uint32_t> chosen, double reach);

  // Calls visit(number) for the points that may lie within the reach of `place`, until it returns false; at
  // most `most_looks` times in a row of cells: the cost of a soup of coinciding points must not grow with the
  // square of its size.
  template <typename Visit>
  void visit_near(const Point& place, int most_looks, Visit&& visit) const {
    const Cell middle = cell_of(place, 0);
    for (const double row : {middle.row - 1, middle.row, middle.row + 1}) {
      const Cell first{row, middle.column - 1, 0};
      auto cell = std::lower_bound(cells_.begin(), cells_.end(), first);
      for (int looks = 0; looks < most_looks && cell != cells_.end(); ++looks, ++cell) {
        if (cell->row != row || cell->column > middle.column + 1) break;
        if (!visit(cell->number)) return;
      }
    }
  }

 private:
  struct Cell {
    double row, column;
    std::uint32_t number;
    bool operator<(const Cell& other) const {
      return std::tie(row, column, number) < std::tie(other.row, other.column, other.number);
    }
  };
  [[nodiscard]] Cell cell_of(const Point& point, std::uint32_t number) const;

  double cell_mm_ = 1;
  std::vector<Cell> cells_;
};

struct JoinedChains {
  struct Link {
    std::uint32_t chain;  // number, in the order of OpenChainJoiner::add
    bool reversed;        // walked from its end to its start (a turned facet)
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
  // Removes all chains.
  void reset(Millimeters tolerance);

  // Adds a chain. `weight`: the number of its points; among chains that disagree about a loop's direction,
  // the heaviest decides.
  void add(Point start, Point end, std::uint32_t weight);

  // Joins all chains. The result is valid until the next reset(). Once the budget is overrun, chains that are
  // not joined yet are closed on themselves.
  [[nodiscard]] const JoinedChains& join(MaskBudget& budget);

 private:
  // End 2i is chain i's start, 2i + 1 its end.
  struct Pair {
    double cost;
    std::uint32_t a, b;
  };

  // An entry of the search's priority queue: a start, and the reduced cost of the path to it.
  struct Step {
    double cost;
    std::uint32_t start;
  };

  // Order of a heap whose first entry has the shortest path (std::push_heap keeps the greatest first).
  [[nodiscard]] static bool heap_order(const Step& a, const Step& b) {
    return a.cost != b.cost ? a.cost > b.cost : a.start > b.start;
  }
  [[nodiscard]] double gap_between(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] double cost_of(std::uint32_t end, std::uint32_t start) const;
  void join_ends(std::uint32_t a, std::uint32_t b);
  void find_free_ends();
  void join_within(double reach, MaskBudget& budget);
  void assign_ends(double reach, MaskBudget& budget);
  void augment_from(std::uint32_t end, double reach);
  void relax_from(std::uint32_t end, double path_cost, double least);
  void flip_augmenting_path(std::uint32_t start);
  void join_turned_runs(double reach, MaskBudget& budget);
  void join_turned_chains(double reach, MaskBudget& budget);
  void join_runs(std::uint32_t a, std::uint32_t b);
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
  std::vector<std::uint32_t> far_end_;  // by free end: the free end at the other side of its joined chains
  std::vector<std::uint32_t> starts_;   // starts of all chains
  PointGrid end_grid_;
  std::vector<Pair> pairs_;
  std::vector<std::uint32_t> reached_in_;   // by start: the last search that reached it
  std::vector<std::uint32_t> predecessor_;  // by start: the end that it was reached from
  std::vector<std::uint32_t> relaxed_in_;   // by start: the last relaxation that reached it
  std::uint32_t relaxation_ = 0;
  std::vector<double> path_cost_;       // by start: cost of the path to it
  std::vector<double> potential_;       // by end: at least 0 for ends, at most 0 for starts
  std::vector<std::uint32_t> settled_;  // starts that a search has passed
  std::vector<std::uint32_t> free_starts_;
  double reassignment_reach_ = 0;  // reach within which ends that have a partner may change it
  std::vector<Step> queue_;        // a heap
  std::uint32_t searches_ = 0;
  int looks_ = 0;                              // starts looked at by all searches of a join()
  std::vector<std::uint32_t> heaviest_first_;  // chains
  std::vector<bool> done_;                     // by chain
  JoinedChains joined_;
};

}  // namespace contourd
