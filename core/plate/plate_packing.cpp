#include "core/plate/plate_packing.hpp"

#include <cstddef>
#include <tuple>

#include "core/contract/expects.hpp"

namespace contourd {
namespace {

std::int64_t right_of(const PlateRectangle& r) {
  return r.left + r.width;
}
std::int64_t back_of(const PlateRectangle& r) {
  return r.front + r.depth;
}

bool holds(const PlateRectangle& outer, const PlateRectangle& inner) {
  return outer.left <= inner.left && outer.front <= inner.front && right_of(outer) >= right_of(inner) &&
         back_of(outer) >= back_of(inner);
}

// Adds the part of `whole` outside `taken`: the largest rectangles on its four sides, which overlap at the
// corners.
void split(const PlateRectangle& whole, const PlateRectangle& taken, std::vector<PlateRectangle>& rest) {
  const bool apart = taken.left >= right_of(whole) || right_of(taken) <= whole.left ||
                     taken.front >= back_of(whole) || back_of(taken) <= whole.front;
  if (apart) return rest.push_back(whole);
  if (taken.left > whole.left)
    rest.push_back({whole.left, whole.front, taken.left - whole.left, whole.depth});
  if (right_of(taken) < right_of(whole))
    rest.push_back({right_of(taken), whole.front, right_of(whole) - right_of(taken), whole.depth});
  if (taken.front > whole.front)
    rest.push_back({whole.left, whole.front, whole.width, taken.front - whole.front});
  if (back_of(taken) < back_of(whole))
    rest.push_back({whole.left, back_of(taken), whole.width, back_of(whole) - back_of(taken)});
}

// Returns the rectangles that do not lie in another one; of equal ones, the first.
std::vector<PlateRectangle> largest_of(const std::vector<PlateRectangle>& all) {
  std::vector<PlateRectangle> kept;
  for (std::size_t i = 0; i < all.size(); ++i) {
    bool held = false;
    for (std::size_t j = 0; j < all.size() && !held; ++j)
      held = i != j && holds(all[j], all[i]) && (j < i || !(all[i] == all[j]));
    if (!held) kept.push_back(all[i]);
  }
  return kept;
}

}  // namespace

PlatePacking::PlatePacking(Pixels width, Pixels depth, Pixels gap)
    : gap_(gap.count()), free_{{0, 0, width.count() + gap_, depth.count() + gap_}} {}

void PlatePacking::occupy(const PlateRectangle& rectangle) {
  // Each rectangle occupies its gap at the right and the back, which keeps the gap to every neighbour.
  const PlateRectangle taken{rectangle.left, rectangle.front, rectangle.width + gap_, rectangle.depth + gap_};
  std::vector<PlateRectangle> rest;
  for (const PlateRectangle& whole : free_)
    split(whole, taken, rest);
  free_ = largest_of(rest);
}

std::optional<PlateRectangle> PlatePacking::find_room(std::int64_t width, std::int64_t depth) {
  expects(width > 0 && depth > 0, "the rectangle has a width and a depth");
  const PlateRectangle* best = nullptr;
  for (const PlateRectangle& each : free_) {
    if (each.width < width + gap_ || each.depth < depth + gap_) continue;
    if (best == nullptr || std::tie(each.front, each.left) < std::tie(best->front, best->left)) best = &each;
  }
  if (best == nullptr) return std::nullopt;
  const PlateRectangle found{best->left, best->front, width, depth};
  occupy(found);
  return found;
}

}  // namespace contourd
