// Cuts sides (directed segments of contours) on an integer grid wherever they meet, and finds the winding
// numbers on both sides of each piece. From the result, ContourUnion reads the union of contours, and
// Rasterizer the outline of the area that overlapping polygons cover together.
//
// A line sweeps over the sides from low y to high y (at equal y from low x) and keeps the sides that it
// crosses in order. Two sides are tested when they become neighbours (Shamos and Hoey 1976, Bentley and
// Ottmann 1979), so the work grows as n log n in the number of sides and of places where they meet. All tests
// use integers and are exact. A crossing is rounded to the grid, and a side that passes a corner within half
// a unit is led through the corner (snap rounding). A crossing whose nearest grid point has already been
// swept is rounded up to a point that has not. If this bends a side past its neighbour, the two exchange
// places in the order, so that searches of the order stay right. Another sweep over the pieces follows if
// sides were exchanged or led through corners.
//
// Working memory is kept between calls: an object allocates only while sections grow. Not thread-safe.
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
    GridPoint low, high;  // the ends, ordered by y, then by x
    std::int32_t turn;    // sides that run up here minus sides that run down; 0: the side is gone (merged)
    std::int32_t winding_left;  // winding number on the left, looking up; on the right it is lower by `turn`
    std::uint32_t loop;         // the loop that the side came from, or one of several
  };

  // Removes all sides. Loops have numbers below `loops`.
  void reset(std::size_t loops);
  // Adds a side from one point to another; ignored if the points are equal.
  void add(GridPoint from, GridPoint to, std::uint32_t loop);

  // Cuts the sides. False if the budget was overrun: the object is then of no use except for reset().
  [[nodiscard]] bool arrange(MaskBudget& budget);

  // Returns the pieces after arrange(): they meet only at their ends, or cross by one unit where a crossing
  // was rounded.
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }
  // True if the loop meets another loop or itself. The sides of any other loop are still there as they were
  // added.
  [[nodiscard]] bool is_cut(std::uint32_t loop) const { return loop_is_cut_[loop] != 0; }
  // True if the winding number is below 0 anywhere.
  [[nodiscard]] bool winds_negatively() const { return winds_negatively_; }

 private:
  static constexpr std::uint32_t kNone = SideOrder::kNone;

  // The beginning or the end of a side.
  struct Event {
    std::uint64_t point;  // the point as a number that sorts in sweep order
    std::uint32_t side;
  };
  [[nodiscard]] static bool comes_before(const Event& a, const Event& b) {
    return a.point != b.point ? a.point < b.point : a.side < b.side;
  }
  [[nodiscard]] static bool comes_after(const Event& a, const Event& b) { return comes_before(b, a); }

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
  void exchange(std::uint32_t left, std::uint32_t right);
  void cut_ahead(std::uint32_t side, GridPoint at);
  [[nodiscard]] std::uint32_t split_off_low_part(std::uint32_t side, GridPoint at);
  void queue(Event event);

  std::vector<Side> sides_;
  std::vector<std::uint8_t> loop_is_cut_;
  bool winds_negatively_ = false;
  bool bent_ = false;          // another sweep is needed
  std::vector<Event> events_;  // events known at the beginning of the sweep, in order
  std::vector<std::uint32_t> row_end_;
  std::size_t next_event_ = 0;
  std::vector<Event> queue_;  // heap of the events that cuts have added
  SideOrder order_;
  // Sides that end and begin at the point that the line passes, and the neighbours left and right of them.
  std::vector<std::uint32_t> ending_, beginning_;
  std::uint32_t left_ = kNone, right_ = kNone;
  std::vector<std::uint32_t> untested_;  // sides that have new neighbours on their right
};

}  // namespace contourd
