#include "core/geometry/side_order.hpp"

#include <utility>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

std::uint32_t mixed(std::uint32_t number) {
  std::uint32_t hash = number * 0x9E3779B1U;
  hash = (hash ^ hash >> 15U) * 0x85EBCA77U;
  return hash ^ hash >> 13U;
}

}  // namespace

void SideOrder::put_under(std::uint32_t parent, std::uint32_t old_child, std::uint32_t child) {
  if (parent == kNone) {
    root_ = child;
  } else if (nodes_[parent].left == old_child) {
    nodes_[parent].left = child;
  } else {
    nodes_[parent].right = child;
  }
  if (child != kNone) nodes_[child].parent = parent;
}

// Exchanges the side with its parent.
void SideOrder::rotate_up(std::uint32_t side) {
  Node& node = nodes_[side];
  const std::uint32_t parent = node.parent;
  Node& above = nodes_[parent];
  put_under(above.parent, parent, side);
  const bool is_left = above.left == side;
  const std::uint32_t moved = std::exchange(is_left ? node.right : node.left, parent);
  (is_left ? above.left : above.right) = moved;
  if (moved != kNone) nodes_[moved].parent = parent;
  above.parent = side;
}

void SideOrder::insert_after(std::uint32_t left_neighbour, std::uint32_t side) {
  expects_costly([&] { return side < nodes_.size(); }, "there is room for the side's number");
  const std::uint32_t right_neighbour = left_neighbour == kNone ? first_ : nodes_[left_neighbour].after;
  expects_costly([&] { return side != left_neighbour && side != right_neighbour; },
                 "a side is not its own neighbour");
  nodes_[side] = {kNone, kNone, kNone, left_neighbour, right_neighbour, mixed(side)};
  if (left_neighbour == kNone) {
    first_ = side;
  } else {
    nodes_[left_neighbour].after = side;
  }
  if (right_neighbour != kNone) nodes_[right_neighbour].before = side;
  // At least one of the two neighbours has no child towards the other.
  if (left_neighbour != kNone && nodes_[left_neighbour].right == kNone) {
    nodes_[left_neighbour].right = side;
    nodes_[side].parent = left_neighbour;
  } else if (right_neighbour != kNone) {
    nodes_[right_neighbour].left = side;
    nodes_[side].parent = right_neighbour;
  } else {
    root_ = side;
  }
  while (nodes_[side].parent != kNone && nodes_[nodes_[side].parent].priority < nodes_[side].priority)
    rotate_up(side);
}

void SideOrder::erase(std::uint32_t side) {
  while (nodes_[side].left != kNone && nodes_[side].right != kNone) {
    const std::uint32_t left = nodes_[side].left, right = nodes_[side].right;
    rotate_up(nodes_[left].priority > nodes_[right].priority ? left : right);
  }
  const Node& node = nodes_[side];
  put_under(node.parent, side, node.left != kNone ? node.left : node.right);
  if (node.before == kNone) {
    first_ = node.after;
  } else {
    nodes_[node.before].after = node.after;
  }
  if (node.after != kNone) nodes_[node.after].before = node.before;
}

void SideOrder::replace(std::uint32_t old, std::uint32_t side) {
  const Node node = nodes_[side] = nodes_[old];
  put_under(node.parent, old, side);
  if (node.left != kNone) nodes_[node.left].parent = side;
  if (node.right != kNone) nodes_[node.right].parent = side;
  if (node.before == kNone) {
    first_ = side;
  } else {
    nodes_[node.before].after = side;
  }
  if (node.after != kNone) nodes_[node.after].before = side;
}

}  // namespace contourd
