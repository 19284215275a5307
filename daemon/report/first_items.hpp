// The beginning of a list, for tables that have a limit. (clang 14 cannot compile libstdc++'s
// std::views::take.)
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace contourd {

// Returns the first items, `most` at most. The list must outlive the span.
template <typename Item>
[[nodiscard]] std::span<const Item> first_items(const std::vector<Item>& items, std::size_t most) {
  return std::span(items).first(std::min(items.size(), most));
}

}  // namespace contourd
