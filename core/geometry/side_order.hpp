// The order of sides along a sweep line, for ArrangedSides: a treap whose nodes are the sides' numbers, so
// that a side is found in logarithmic time and its neighbours at once. The shape of the treap depends on the
// numbers alone. Not thread-safe; allocates only while the numbers grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace contourd {

class SideOrder {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  void clear() { root_ = first_ = kNone; }
  // Makes room for side numbers below `count`.
  void reserve_numbers(std::size_t count) {
    if (nodes_.size() < count) nodes_.resize(count);
  }

  [[nodiscard]] std::uint32_t first() const { return first_; }
  [[nodiscard]] std::uint32_t before(std::uint32_t side) const { return nodes_[side].before; }
  [[nodiscard]] std::uint32_t after(std::uint32_t side) const { return nodes_[side].after; }

  // Returns the last side for which `is_left_of_it(side)` does not hold, kNone if it holds for all.
  template <typename IsLeftOfIt>
  [[nodiscard]] std::uint32_t last_not_right(IsLeftOfIt&& is_left_of_it) const {
    std::uint32_t found = kNone;
    for (std::uint32_t at = root_; at != kNone;) {
      if (is_left_of_it(at)) {
        at = nodes_[at].left;
      } else {
        found = at;
        at = nodes_[at].right;
      }
    }
    return found;
  }

  // Inserts a side to the right of `left_neighbour`, or as the first if that is kNone. The side must not be
  // in the order yet. REQUIRES: there is room for the side's number; the side is not its own neighbour.
  void insert_after(std::uint32_t left_neighbour, std::uint32_t side);
  void erase(std::uint32_t side);
  // Puts `side` in the place of `old`.
  void replace(std::uint32_t old, std::uint32_t side);

 private:
  struct Node {
    std::uint32_t parent, left, right, before, after;
    std::uint32_t priority;  // no higher than its parent's
  };

  void put_under(std::uint32_t parent, std::uint32_t old_child, std::uint32_t child);
  void rotate_up(std::uint32_t side);

  std::uint32_t root_ = kNone, first_ = kNone;
  std::vector<Node> nodes_;
};

}  // namespace contourd
