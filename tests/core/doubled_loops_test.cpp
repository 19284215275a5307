#include "core/doubled_loops.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "tests/core/random_shapes.hpp"

using namespace contourd;

namespace {

using Place = std::pair<double, double>;
using Ends = std::pair<Place, Place>;

Place place(const Point& point) {
  return {point.x, point.y};
}

std::map<Ends, int> counted(const std::vector<Segment>& segments) {
  std::map<Ends, int> counts;
  for (const Segment& s : segments)
    ++counts[{place(s.from), place(s.to)}];
  return counts;
}

// By point: how many more segments leave than arrive, where any do.
std::map<Place, int> surplus(const std::vector<Segment>& segments) {
  std::map<Place, int> surplus;
  for (const Segment& s : segments) {
    ++surplus[place(s.from)];
    --surplus[place(s.to)];
  }
  std::erase_if(surplus, [](const auto& point) { return point.second == 0; });
  return surplus;
}

// Whether some of these lead head to tail back to their start.
bool hold_a_loop(std::set<Ends> segments) {
  // What leads nowhere is no part of one.
  while (std::erase_if(segments, [&segments](const Ends& s) {
           return std::ranges::none_of(segments, [&s](const Ends& next) { return next.first == s.second; });
         }) > 0) {
  }
  return !segments.empty();
}

std::vector<Segment> soup_with_doubles() {
  const auto coordinate = [] { return static_cast<double>(testing::draw(0, 2)); };
  std::vector<Segment> segments;
  const std::int64_t count = testing::draw(1, 30);
  for (std::int64_t i = 0; i < count; ++i) {
    Segment s{{coordinate(), coordinate()}, {coordinate(), coordinate()}};
    if (s.from == s.to) s.to.x += 1;
    const std::int64_t times = testing::draw(1, 3);
    for (std::int64_t time = 0; time < times; ++time)
      segments.insert(segments.begin() + testing::draw(0, std::ssize(segments)), s);
  }
  return segments;
}

}  // namespace

TEST_CASE("Of doubled segments as much is left out as closes, and nothing that is there once") {
  CHECK(rc::check([] {
    const std::vector<Segment> before = soup_with_doubles();
    std::vector<Segment> after = before;
    DoubledLoops().drop_from(after);
    RC_ASSERT(surplus(after) == surplus(before));
    const std::map<Ends, int> counts = counted(after);
    for (const auto& [ends, count] : counted(before))
      RC_ASSERT(counts.contains(ends));
    std::set<Ends> spare;
    for (const auto& [ends, count] : counts) {
      if (count > 1) spare.insert(ends);
    }
    RC_ASSERT(!hold_a_loop(spare));
    auto next = before.begin();
    for (const Segment& s : after) {
      next = std::find(next, before.end(), s);
      RC_ASSERT(next != before.end());
      ++next;
    }
  }));
}

TEST_CASE("Ten thousand copies of a loop are one") {
  const std::vector<Point> corners{{0, 0}, {4, 0}, {4, 3}, {0, 3}};
  std::vector<Segment> segments;
  for (int copy = 0; copy < 10'000; ++copy) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      segments.push_back({corners[i], corners[(i + 1) % corners.size()]});
  }
  DoubledLoops().drop_from(segments);
  CHECK(segments.size() == corners.size());
}
