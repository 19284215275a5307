#include "core/model/shell_report.hpp"

#include "core/model/height_index.hpp"
#include "core/model/placement.hpp"
#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/damage.hpp"

using models::inverted;
using models::together;

namespace {

const models::Facets kBlock = models::box({0, 0, 0}, {10, 10, 10});
const models::Facets kCore = models::box({3, 3, 3}, {7, 7, 7});

// Returns the report of the repaired model, as it is and turned by angles that no axis divides.
ShellReport report_of(models::Facets facets) {
  const ShellReport report = inspect_shells(HeightIndex(facets).facets());
  orient(facets, {.x_deg = 31, .y_deg = -17, .z_deg = 203});
  const ShellReport turned = inspect_shells(HeightIndex(facets).facets());
  CHECK(turned.inside_out == report.inside_out);
  CHECK(turned.within == report.within);
  return report;
}

}  // namespace

TEST_CASE("Sound shells are right: alone, apart, overlapping, touching, nested and hollow") {
  const models::Facets cavity = inverted(models::box({2, 2, 2}, {8, 8, 8}));
  for (const models::Facets& facets :
       {kBlock, together(kBlock, models::box({20, 0, 0}, {25, 5, 5})),
        together(kBlock, models::box({5, 5, 5}, {15, 15, 15})),
        together(kBlock, models::box({0, 0, 10}, {10, 10, 12})),
        together(kBlock, models::box({2, 3, 10}, {7, 8, 12})), together(kBlock, inverted(kCore)),
        together({kBlock, cavity, kCore}),
        together({kBlock, cavity, kCore, inverted(models::box({4, 4, 4}, {6, 6, 6}))}),
        together(models::sphere(9, 16), inverted(models::sphere(5, 12)))})
    CHECK(report_of(facets) == ShellReport{});
}

TEST_CASE("A shell that faces inwards outside of solids is inside out") {
  // Apart, on top of the block, partly in it, and across it.
  for (const models::Facets& shell :
       {models::box({20, 0, 0}, {25, 5, 5}), models::box({2, 3, 10}, {7, 8, 12}),
        models::box({2, 3, 9}, {7, 8, 12}), models::box({-1, 4, 4}, {11, 6, 6})}) {
    const ShellReport report = report_of(together(kBlock, inverted(shell)));
    CHECK(report.inside_out == 1);
    CHECK(report.within == 0);
  }
  // The block's edges part the shell that stands on all of its top.
  CHECK(report_of(together(kBlock, inverted(models::box({0, 0, 10}, {10, 10, 12})))).inside_out == 2);
  const models::Facets ball = models::sphere(2, 10);
  CHECK(report_of(together({models::sphere(9, 16), inverted(models::sphere(5, 12)), inverted(ball)}))
            .inside_out == 1);
}

TEST_CASE("A shell that faces outwards within a solid is found, unless shells reach into each other") {
  const ShellReport report = report_of(together(kBlock, kCore));
  CHECK(report.within == 1);
  CHECK(report.inside_out == 0);
  CHECK(bounds_of(kCore).min_x <= report.within_at.x);
  CHECK(report_of(together({kBlock, models::box({1, 1, 1}, {3, 3, 3}), models::box({6, 6, 6}, {9, 9, 9})}))
            .within == 2);
  const models::Facets peg = models::box({4, 4, 8}, {6, 6, 12});
  CHECK(report_of(together({kBlock, kCore, peg})) == ShellReport{});
  // A body whose corner alone leaves the solid.
  CHECK(report_of(together(kBlock, models::cone(4, 10.5, 12))) == ShellReport{});
}

TEST_CASE("A thin pin or a ball that sticks out of a solid, but for its end, is not within the solid") {
  const auto moved = [](models::Facets facets, float x, float y, float z) {
    models::translate(facets, x, y, z);
    return facets;
  };
  for (const int sides : {8, 16, 32, 60}) {
    // Faces of the lower cap, the upper cap and the wall take turns.
    models::Facets pin;
    const models::Facets wall =
        models::lathe(std::vector<Point>{{0, 0}, {0.05, 0}, {0.05, 5.1}, {0, 5.1}}, sides);
    const std::size_t rows = wall.size() / static_cast<std::size_t>(sides);
    for (std::size_t side = 0; side < static_cast<std::size_t>(sides); ++side)
      for (std::size_t row = 0; row < rows; ++row)
        pin.push_back(wall[row * static_cast<std::size_t>(sides) + side]);
    CAPTURE(sides);
    CHECK(inspect_shells(together(kBlock, moved(pin, 5, 5, 9.9F))) == ShellReport{});
    CHECK(inspect_shells(together(kBlock, moved(wall, 5, 5, 9.9F))) == ShellReport{});
    CHECK(inspect_shells(together(kBlock, moved(pin, 5, 5, 4))).within == 1);
  }
  CHECK(inspect_shells(together(moved(models::globe(3, 24, 32), 0, 0, 8), models::cone(1, 5.2, 16))) ==
        ShellReport{});
}

TEST_CASE("Cavities that reach into each other are reported, however little, but not those that touch") {
  const models::Facets first = inverted(models::box({2, 2, 2}, {5, 5, 5}));
  for (const float low : {3.0F, 4.0F, 4.8F}) {
    CAPTURE(low);
    const models::Facets second = inverted(models::box({low, low, low}, {8, 8, 8}));
    CHECK(report_of(together({kBlock, first, second})).inside_out > 0);
  }
  CHECK(report_of(together({kBlock, first, inverted(models::box({5, 2.5F, 2.5F}, {8, 4, 4}))})) ==
        ShellReport{});
  CHECK(report_of(together({kBlock, first, inverted(models::box({6, 6, 6}, {8, 8, 8}))})) == ShellReport{});
}

TEST_CASE("A cavity that another solid fills is found, wherever the solids overlap") {
  const models::Facets cavity = inverted(kCore);
  // The other solid contains the cavity, cuts it in half, contains the block or equals it nearly.
  for (const models::Facets& other :
       {models::box({2, 2, 2}, {12, 12, 12}), models::box({5, 2, 2}, {12, 12, 12}),
        models::box({-1, -1, -1}, {11, 11, 11}), models::box({0.1F, 0.1F, 0.1F}, {10.1F, 10.1F, 10.1F})}) {
    const ShellReport report = report_of(together({kBlock, other, cavity}));
    CHECK(report.filled == 1);
    CHECK(report.inside_out == 0);
    CHECK(bounds_of(kCore).min_x <= report.filled_at.x);
    CHECK(report_of(together({cavity, other, kBlock})).filled == 1);
  }
  // A pillar in the cavity, and a cavity of each of two solids.
  CHECK(report_of(together({kBlock, cavity, models::box({4.5F, 4.5F, 2}, {5.5F, 5.5F, 8})})) ==
        ShellReport{});
  CHECK(report_of(together({kBlock, models::box({2, 2, 2}, {12, 12, 12}), cavity, cavity})).filled == 0);
}

TEST_CASE("A shell is named by a vertex of it") {
  const ShellReport report =
      inspect_shells(together(kBlock, inverted(models::box({20, 30, 40}, {21, 31, 41}))));
  CHECK(report.inside_out_at.x >= 20);
  CHECK(report.inside_out_at.y >= 30);
  CHECK(report.inside_out_at.z >= 40);
}

TEST_CASE("Shells with holes and folds do not count as inside out") {
  models::Dice dice(3);
  models::Facets folded = models::sphere(5, 12);
  models::shake_vertices(folded, 0.6, dice);
  CHECK(inspect_shells(together(folded, models::box({10, 0, 0}, {12, 2, 2}))).inside_out == 0);
  models::Facets holed = models::sphere(5, 12);
  models::drop_facets(holed, 0.02, dice);
  CHECK(inspect_shells(together(holed, models::box({10, 0, 0}, {12, 2, 2}))) == ShellReport{});
  CHECK(inspect_shells({}) == ShellReport{});
}
