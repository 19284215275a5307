#include "core/plate/plate_packing.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

// True if the rectangles keep the gap.
bool apart(const PlateRectangle& a, const PlateRectangle& b, std::int64_t gap) {
  return a.left + a.width + gap <= b.left || b.left + b.width + gap <= a.left ||
         a.front + a.depth + gap <= b.front || b.front + b.depth + gap <= a.front;
}

}  // namespace

TEST_CASE("Rectangles fill the plate from the front left, with gaps between them and none at the edges") {
  PlatePacking packing(Pixels{96}, Pixels{54}, Pixels{2});
  const PlateRectangle expected[]{{0, 0, 20, 20},  {22, 0, 20, 20},  {44, 0, 20, 20},  {66, 0, 20, 20},
                                  {0, 22, 20, 20}, {22, 22, 20, 20}, {44, 22, 20, 20}, {66, 22, 20, 20}};
  for (const PlateRectangle& each : expected)
    CHECK(packing.find_room(20, 20) == each);
  CHECK_FALSE(packing.find_room(20, 20));
  CHECK(packing.find_room(8, 54) == PlateRectangle{88, 0, 8, 54});
  CHECK(packing.find_room(86, 10) == PlateRectangle{0, 44, 86, 10});
  CHECK_FALSE(packing.find_room(1, 1));
}

TEST_CASE("A rectangle as large as the plate fits, a larger one does not") {
  PlatePacking packing(Pixels{96}, Pixels{54}, Pixels{2});
  CHECK_FALSE(packing.find_room(97, 1));
  CHECK_FALSE(packing.find_room(1, 55));
  CHECK(packing.find_room(96, 54) == PlateRectangle{0, 0, 96, 54});
}

TEST_CASE(
    "Found rectangles are on the plate and apart from all others, and room is found as long as there is "
    "any") {
  CHECK(rc::check([] {
    const std::int64_t width = draw(10, 60), depth = draw(10, 60), gap = draw(0, 3);
    PlatePacking packing(Pixels{static_cast<std::int32_t>(width)}, Pixels{static_cast<std::int32_t>(depth)},
                         Pixels{static_cast<std::int32_t>(gap)});
    std::vector<PlateRectangle> taken;
    for (std::int64_t i = draw(0, 3); i > 0; --i) {
      taken.push_back({draw(-10, 60), draw(-10, 60), draw(1, 20), draw(1, 20)});
      packing.occupy(taken.back());
    }
    for (int i = 0; i < 12; ++i) {
      const std::int64_t w = draw(1, 25), d = draw(1, 25);
      const auto free_at = [&](std::int64_t left, std::int64_t front) {
        return std::ranges::all_of(taken, [&](const PlateRectangle& other) {
          return apart({left, front, w, d}, other, gap);
        });
      };
      const auto found = packing.find_room(w, d);
      if (found) {
        RC_ASSERT(found->width == w && found->depth == d);
        RC_ASSERT(found->left >= 0 && found->left + w <= width);
        RC_ASSERT(found->front >= 0 && found->front + d <= depth);
        RC_ASSERT(free_at(found->left, found->front));
        taken.push_back(*found);
        continue;
      }
      for (std::int64_t left = 0; left + w <= width; ++left) {
        for (std::int64_t front = 0; front + d <= depth; ++front)
          RC_ASSERT_FALSE(free_at(left, front));
      }
    }
  }));
}
