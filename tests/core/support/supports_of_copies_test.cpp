#include "core/support/supports_of_copies.hpp"

#include <algorithm>
#include <vector>

#include "tests/catch.hpp"

namespace {

// A pillar at x whose tip leans to another x.
void add_tree(std::vector<SupportPrimitive>& primitives, double x, double tip_x) {
  primitives.push_back(Frustum{{x, 0, 0}, {x, 0, 4}, 0.5, 0.5});
  primitives.push_back(Ball{{x, 0, 4}, 0.5});
  primitives.push_back(Frustum{{x, 0, 4}, {tip_x, 0, 5}, 0.5, 0.2});
}

std::size_t left_of(const std::vector<SupportPrimitive>& primitives, bool first, bool second) {
  const std::vector<CopyOutline> copies{{{-10, -5}, {-1, 5}, first}, {{1, -5}, {10, 5}, second}};
  const auto left = supports_of_printed(SupportStructure(primitives), copies);
  CHECK(std::ranges::all_of(left->primitives(), [&](const SupportPrimitive& each) {
    return std::ranges::find(primitives, each) != primitives.end();
  }));
  return left->primitives().size();
}

}  // namespace

TEST_CASE("The supports of a copy that is no longer printed go, and those of others stay") {
  std::vector<SupportPrimitive> primitives;
  add_tree(primitives, -5, -5);
  add_tree(primitives, 0, 2);  // the pillar stands between the copies
  add_tree(primitives, 5, 6);
  CHECK(left_of(primitives, true, true) == 9);
  CHECK(left_of(primitives, false, true) == 6);
  CHECK(left_of(primitives, true, false) == 3);
  CHECK(left_of(primitives, false, false) == 0);
}

TEST_CASE("A tree that holds two copies stays until neither is printed, and one that holds none stays") {
  std::vector<SupportPrimitive> primitives;
  add_tree(primitives, 0, 2);
  primitives.push_back(Frustum{{0, 0, 4}, {-2, 0, 6}, 0.5, 0.2});  // a second branch of the same tree
  CHECK(left_of(primitives, false, true) == 4);
  CHECK(left_of(primitives, false, false) == 0);
  primitives.push_back(Frustum{{0, 20, 0}, {0, 20, 4}, 0.5, 0.5});
  CHECK(left_of(primitives, false, false) == 1);
}
