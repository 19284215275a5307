#include "core/contour/contour_union.hpp"

#include "core/contour/filled_area.hpp"
#include "tests/catch.hpp"
#include "tests/core/near.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/section_fixture.hpp"

namespace {

Contours outline_of(const std::vector<Loop>& loops, FillRule rule = FillRule::NonZero) {
  Contours outline;
  ContourUnion().unite(contours_from(loops), rule, ContourUnion::kFileRounding, outline);
  return outline;
}

// Cuts are rounded: points nearer than 2^-15 mm count as equal, along some 100 mm of sides.
constexpr double kAreaMm2 = 100.0 / 32768;

}  // namespace

TEST_CASE("Sound loops that touch nothing stay as they are") {
  const std::vector<Loop> loops{rectangle(0, 0, 10, 10), turned(rectangle(2, 2, 8, 8)),
                                circle({20, 0}, 3, 50)};
  const Contours outline = outline_of(loops);
  CHECK(outline.points == contours_from(loops).points);
  CHECK(outline.loops.size() == 3);
}

TEST_CASE("Overlapping solids become one loop") {
  const Contours outline = outline_of({rectangle(0, 0, 10, 10), rectangle(5, 5, 15, 15)});
  REQUIRE(outline.loops.size() == 1);
  CHECK(outline.points.size() == 8);
  CHECK(near(signed_area(outline), 175, 1e-12));
}

TEST_CASE("Solids that share a wall or a part of one become one loop without it") {
  for (const double low : {0.0, -3.0, 2.0, 7.0}) {
    for (const double gap : {0.0, 1e-6, -1e-6}) {  // a float's rounding
      const Contours outline = outline_of({rectangle(0, 0, 10, 10), rectangle(10 + gap, low, 20, low + 5)});
      CAPTURE(low, gap);
      CHECK(outline.loops.size() == 1);
      CHECK(near(signed_area(outline), 150, kAreaMm2));
    }
  }
}

TEST_CASE("A solid inside another and a duplicate solid leave no trace") {
  CHECK(outline_of({rectangle(0, 0, 10, 10), rectangle(2, 2, 4, 4)}).loops.size() == 1);
  const Contours outline = outline_of({rectangle(0, 0, 10, 10), rectangle(0, 0, 10, 10)});
  CHECK(near(filled_area_mm2(outline), 100, 1e-12));
}

TEST_CASE("Loops that run the wrong way are turned") {
  const Contours outline =
      outline_of({turned(rectangle(0, 0, 10, 10)), rectangle(2, 2, 8, 8), turned(rectangle(4, 4, 5, 5))});
  CHECK(outline.loops.size() == 3);
  CHECK(signed_area(outline) == 100 - 36 + 1);
}

TEST_CASE("By the positive rule, areas wound the other way are empty") {
  CHECK(outline_of({turned(rectangle(0, 0, 10, 10))}, FillRule::Positive).loops.empty());
  // A bow tie: one half runs each way.
  const Loop bow_tie{{0, 0}, {10, 10}, {10, 0}, {0, 10}};
  CHECK(near(signed_area(outline_of({bow_tie}, FillRule::Positive)), 25, 1e-12));
  CHECK(near(signed_area(outline_of({bow_tie}, FillRule::NonZero)), 50, 1e-12));
}

TEST_CASE("Loops without area give no outline") {
  CHECK(outline_of({}).loops.empty());
  CHECK(outline_of({{{1, 1}}, {{1, 1}, {2, 2}}, {{0, 0}, {5, 0}, {9, 0}}, {{3, 3}, {3, 3}, {3, 3}}})
            .loops.empty());
}

TEST_CASE("An outline fills what its contours fill, counter-clockwise") {
  CHECK(rc::check([] {
    std::vector<Loop> loops(static_cast<std::size_t>(draw(1, 4)));
    for (Loop& loop : loops)
      loop = loop_of(draw_polygon(-20, 20, -20, 20));
    const Contours contours = contours_from(loops);
    for (const FillRule rule : {FillRule::NonZero, FillRule::Positive}) {
      Contours outline;
      ContourUnion().unite(contours, rule, ContourUnion::kFileRounding, outline);
      for (int i = 0; i < 300; ++i) {
        const Point p{draw_real(-21, 21), draw_real(-21, 21)};
        // Within some roundings of a side either answer is right.
        if (distance_to_sides(contours, p) < 4.0 / 32768) continue;
        const int winding = winding_around(contours, p);
        const bool inside = rule == FillRule::Positive ? winding > 0 : winding != 0;
        // Where three sides almost meet in a point, an inner wall may remain and wind twice.
        RC_ASSERT((winding_around(outline, p) > 0) == inside);
        RC_ASSERT(winding_around(outline, p) >= 0);
      }
    }
  }));
}
