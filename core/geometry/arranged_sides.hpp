// Directed sides on a grid of whole numbers, cut wherever they meet, with the winding number on both sides of
// each: what a union is read from.
//
// A line sweeps over the sides from low y to high y (at equal y from low x) and keeps those that it crosses
// in order. Sides are tested where they become neighbours (Shamos and Hoey 1976, Bentley and Ottmann 1979),
// so the work grows as n log n in sides and places where they meet. All tests are of whole numbers and exact.
// A crossing is rounded to the grid, and a side that passes a corner within half a unit is led through it
// (snap rounding). Where that bends a side onto another or past it, another sweep over the pieces follows.
//
// Keeps its working memory between calls: allocates only while sections grow. Not thread-safe.
//
// It has many functions, each of a few lines: the steps of one sweep, which all work on the same sides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/mask_budget.hpp"
#include "core/geometry/side_order.hpp"

namespace contourd {

class ArrangedSides {
 public:
  // Coordinates reach from -kReach to kReach: products of their differences fit into 64 bits.
  static constexpr std::int32_t kReach = 1 << 29;
  struct GridPoint {
    std::int32_t x, y;
    bool operator==(const GridPoint&) const = default;
  };

  struct Side {
    GridPoint low, high;        // by y, then by x
    std::int32_t turn;          // how many more run up here than down; 0: there is nothing here any more
    std::int32_t winding_left;  // seen upwards, x to the right; right of it there is `turn` less
    std::uint32_t loop;         // which it came from, or one of them
    bool cut_later;             // see later_cuts_
  };

  // Forgets all sides. Loops have numbers below `loops`.
  void reset(std::size_t loops);
  // From one point to another; nothing where they are the same.
  void add(GridPoint from, GridPoint to, std::uint32_t loop);

  // Cuts them. False when the budget was overrun: they are of no use then but for reset().
  [[nodiscard]] bool arrange(MaskBudget& budget);

  // After that: no two meet but in their ends, or cross by a unit where a crossing was rounded.
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }
  // Whether the loop meets another, or itself. What does not is still there, side by side as it was added.
  [[nodiscard]] bool is_cut(std::uint32_t loop) const { return loop_is_cut_[loop] != 0; }
  // Whether anywhere the winding number is below 0.
  [[nodiscard]] bool winds_negatively() const { return winds_negatively_; }

 private:
  static constexpr std::uint32_t kNone = SideOrder::kNone;

  // A side begins or ends in a point.
  struct Event {
    std::uint64_t point;  // the order of points as a number
    std::uint32_t side;
    bool begins;
  };
  [[nodiscard]] static bool comes_before(const Event& a, const Event& b) {
    return a.point != b.point ? a.point < b.point : a.side < b.side;
  }
  [[nodiscard]] static bool comes_after(const Event& a, const Event& b) { return comes_before(b, a); }
  struct LaterCut {
    std::uint32_t side;
    GridPoint at;
  };

  [[nodiscard]] bool sweep(MaskBudget& budget);
  void make_events();
  static void sort_row(std::span<Event> row);
  [[nodiscard]] bool take_events(GridPoint& point);
  void take(const Event& event);
  void pass(GridPoint point);
  void find_neighbours(GridPoint point);
  [[nodiscard]] bool meets(std::uint32_t side, GridPoint point) const;
  [[nodiscard]] std::uint32_t cut_if_it_passes(std::uint32_t side, GridPoint point);
  void note_cut_loops();
  void sort_beginning();
  void merge_beginning();
  void exchange_in_order();
  void test(std::uint32_t left, std::uint32_t right, GridPoint swept_to);
  void cut_ahead(std::uint32_t side, GridPoint at, GridPoint swept_to);
  [[nodiscard]] std::uint32_t split_off_low_part(std::uint32_t side, GridPoint at);
  void make_later_cuts();
  void queue(Event event);

  std::vector<Side> sides_;
  std::vector<std::uint8_t> loop_is_cut_;
  bool winds_negatively_ = false;
  bool bent_ = false;          // another sweep is needed
  std::vector<Event> events_;  // known from the start, in order
  std::vector<std::uint32_t> row_end_;
  std::size_t next_event_ = 0;
  std::vector<Event> queue_;  // a heap of those that cuts have made
  SideOrder order_;
  // In the point that the line passes: what ends and begins there, and what is left and right of that.
  std::vector<std::uint32_t> ending_, beginning_;
  std::uint32_t left_ = kNone, right_ = kNone;
  // Cuts that fall behind the line, or turn a part of the side round: made after the sweep.
  std::vector<LaterCut> later_cuts_;
};

}  // namespace contourd
