// Sorting of what lies on rays, which have few items each. Pure; thread-safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "core/cure/stop_check.hpp"

namespace contourd {

// Sorts items by the number of their ray, and those of a ray by `less`: counts the items of each ray, puts
// each item into the room of its ray, and sorts there. Takes as much memory again. Throws ComputationStopped.
template <typename Item, typename Less>
void sort_by_ray(std::vector<Item>& items, std::uint32_t Item::*ray, Less less, StopCheck& check) {
  if (items.empty()) return;
  const auto last = static_cast<std::size_t>(std::invoke(ray, *std::ranges::max_element(items, {}, ray)));
  check.spend(items.size() + last);
  std::vector<std::size_t> begins(last + 2);
  for (const Item& item : items)
    ++begins[static_cast<std::size_t>(item.*ray) + 1];
  for (std::size_t each = 1; each < begins.size(); ++each)
    begins[each] += begins[each - 1];
  std::vector<Item> sorted(items.size());
  for (const Item& item : items)
    sorted[begins[static_cast<std::size_t>(item.*ray)]++] = item;
  items = std::move(sorted);
  // Each ray's room begins where that of the ray before ends.
  for (std::size_t from = 0, each = 0; each <= last; from = begins[each++]) {
    if (begins[each] - from < 2) continue;
    std::sort(items.begin() + static_cast<std::ptrdiff_t>(from),
              items.begin() + static_cast<std::ptrdiff_t>(begins[each]), less);
    check.spend(begins[each] - from);
  }
}

}  // namespace contourd
