#include "core/contour/segment_ends.hpp"

#include "tests/catch.hpp"
#include "tests/random_shapes.hpp"

namespace {

// Segments between few points, so that most points have several. -0 and 0 are the same place.
std::vector<Segment> few_points_many_segments() {
  const auto coordinate = [] {
    const std::int64_t number = testing::draw(-1, 2);
    return number < 0 ? -0.0 : static_cast<double>(number);
  };
  std::vector<Segment> segments(static_cast<std::size_t>(testing::draw(1, 40)));
  for (Segment& segment : segments)
    segment = {{coordinate(), coordinate()}, {coordinate(), coordinate()}};
  return segments;
}

std::vector<std::uint32_t> leaving(const SegmentEnds& ends, const Point& point) {
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = ends.first_leaving(point); i != SegmentEnds::kNone; i = ends.next_leaving(i))
    numbers.push_back(i);
  return numbers;
}

}  // namespace

TEST_CASE("The segments that leave a point are found from the last to the first") {
  CHECK(rc::check([] {
    SegmentEnds ends;
    // Reset twice: an earlier section must not show.
    const std::vector<Segment> earlier = few_points_many_segments();
    ends.reset(earlier);
    const std::vector<Segment> segments = few_points_many_segments();
    ends.reset(segments);
    for (const double x : {0.0, 1.0, 2.0, 3.0}) {
      for (const double y : {0.0, 1.0, 2.0}) {
        std::vector<std::uint32_t> expected;
        for (std::uint32_t i = static_cast<std::uint32_t>(segments.size()); i-- > 0;) {
          if (segments[i].from == Point{x, y}) expected.push_back(i);
        }
        RC_ASSERT(leaving(ends, {x, y}) == expected);
      }
    }
  }));
}

TEST_CASE("A point that more segments leave than reach, or fewer, is unbalanced") {
  CHECK(rc::check([] {
    const std::vector<Segment> segments = few_points_many_segments();
    SegmentEnds ends;
    ends.reset(segments);
    std::map<std::pair<double, double>, int> surplus;
    for (const Segment& segment : segments) {
      ++surplus[{segment.from.x, segment.from.y}];
      --surplus[{segment.to.x, segment.to.y}];
    }
    std::size_t starts = 0;
    for (const auto& [place, more] : surplus) {
      const SegmentEnds::UnbalancedPoint* unbalanced = ends.unbalanced_at({place.first, place.second});
      RC_ASSERT((unbalanced == nullptr ? 0 : unbalanced->leaving_minus_arriving) == more);
      if (more > 0) ++starts;
    }
    RC_ASSERT(ends.starts().size() == starts);
    for (std::size_t i = 1; i < starts; ++i)
      RC_ASSERT(ends.starts()[i - 1]->first_end < ends.starts()[i]->first_end);
  }));
}
