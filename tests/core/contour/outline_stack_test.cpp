#include "core/contour/outline_stack.hpp"

#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

namespace {

constexpr Nanometers kThickness{50'000};

// Returns squares, each with its lower left corner at (at, at).
Contours squares(const std::vector<double>& at, double side = 1) {
  Contours contours;
  for (const double low : at) {
    contours.loops.push_back({static_cast<std::uint32_t>(contours.points.size()), 4});
    for (const Point corner : {Point{0, 0}, Point{side, 0}, Point{side, side}, Point{0, side}})
      contours.points.push_back({low + corner.x, low + corner.y});
  }
  return contours;
}

}  // namespace

TEST_CASE("A stack of outlines gives the layer at a height, whose lower side belongs to it") {
  OutlineStack stack(kThickness);
  stack.add(squares({-3, 0.25}));
  stack.add(Contours{});
  stack.add(squares({2}));
  CHECK(stack.layers() == 3);
  CHECK(stack.most_points() == 8);
  Contours section;
  const auto points_at = [&](std::int64_t nm) {
    stack.section_at(Nanometers{nm}, section);
    CHECK(stack.points_at(Nanometers{nm}) == section.points.size());
    return section.points.size();
  };
  CHECK(points_at(-1) == 0);
  CHECK(points_at(0) == 8);
  CHECK(section.points == squares({-3, 0.25}).points);
  CHECK(section.loops.size() == 2);
  CHECK(section.points_of(section.loops[1])[0] == Point{0.25, 0.25});
  CHECK(points_at(49'999) == 8);
  CHECK(points_at(50'000) == 0);
  CHECK(points_at(100'000) == 4);
  CHECK(points_at(150'000) == 0);
  REQUIRE(stack.box());
  CHECK(stack.box()->low == Point{-3, -3});
  CHECK(stack.box()->high == Point{3, 3});
}

TEST_CASE("Outlines are stored to the nanometre, and a layer equal to the one beneath takes no points") {
  OutlineStack stack(kThickness);
  CHECK_FALSE(stack.box());
  const std::vector<double> hundred(100, 0.123456789);
  stack.add(squares(hundred));
  const std::size_t bytes = stack.bytes();
  for (int i = 0; i < 9; ++i)
    stack.add(squares(hundred));
  CHECK(stack.bytes() < 3 * bytes);
  Contours section;
  stack.section_at(kThickness * 3, section);
  CHECK(section.points.size() == 400);
  CHECK(section.points[0].x == 0.123457);
  // Equal points in other loops are another layer.
  Contours other = squares(hundred);
  other.loops.resize(1);
  other.loops.front().point_count = 400;
  stack.add(other);
  stack.section_at(kThickness * 10, section);
  CHECK(section.loops.size() == 1);
}

TEST_CASE("OutlineStack requires a thickness, and outlines near the plate") {
  CHECK(contract_broken_by([] { OutlineStack{Nanometers{0}}; }) == "a layer has a thickness");
  OutlineStack stack(kThickness);
  for (const double far : {2000.1, -2000.1, std::numeric_limits<double>::quiet_NaN()})
    CHECK(contract_broken_by([&] { stack.add(squares({far}, 0)); }) == "outlines are near the plate");
}
