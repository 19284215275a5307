#include "core/support/support_structure.hpp"

#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/core/support/random_primitives.hpp"
#include "tests/core/warm_allocations.hpp"

namespace {

std::vector<SupportPrimitive> draw_primitives(std::int64_t most) {
  std::vector<SupportPrimitive> primitives(static_cast<std::size_t>(draw(0, most)));
  for (SupportPrimitive& primitive : primitives)
    primitive = draw_primitive();
  return primitives;
}

// Pillars with feet, branches and tips on a plate.
std::vector<SupportPrimitive> forest(int side) {
  std::vector<SupportPrimitive> primitives;
  for (int i = 0; i < side * side; ++i) {
    const double x = 3 * (i % side - side / 2), y = 3 * (i / side - side / 2), top = 5 + i % 7;
    primitives.push_back(Frustum{{x, y, 0}, {x, y, 1}, 2, 0.5});
    primitives.push_back(Frustum{{x, y, 1}, {x, y, top}, 0.5, 0.5});
    primitives.push_back(Ball{{x, y, top}, 0.5});
    primitives.push_back(Frustum{{x, y, top}, {x + 1, y + 0.5, top + 1.5}, 0.5, 0.2});
  }
  return primitives;
}

}  // namespace

TEST_CASE("A section has a loop for each primitive that the height cuts") {
  CHECK(rc::check([] {
    const SupportStructure structure(draw_primitives(60));
    // Some heights are ends of primitives.
    double z = draw_real(-2, 10);
    if (!structure.primitives().empty() && draw(0, 2) == 0)
      z = reach_of(structure.primitives().front()).bottom;
    const Nanometers height = to_nanometers(Millimeters{z}).value();
    Contours contours, naive;
    structure.section_at(height, contours);
    for (const SupportPrimitive& primitive : structure.primitives()) {
      const double z_mm = to_millimeters(height).count();
      const HeightReach reach = reach_of(primitive);
      if (z_mm < reach.bottom || z_mm >= reach.top) continue;
      if (const auto cut = cut_at(primitive, z_mm)) append_outline(*cut, naive);
    }
    RC_ASSERT(contours.loops.size() == naive.loops.size());
    const auto sorted = [](std::vector<Point> points) {
      std::ranges::sort(
          points, [](const Point& a, const Point& b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
      return points;
    };
    RC_ASSERT(sorted(contours.points) == sorted(naive.points));
  }));
}

TEST_CASE("A section replaces the previous contours") {
  const SupportStructure structure({Ball{{0, 0, 1}, 1}});
  Contours contours;
  structure.section_at(Nanometers{1'000'000}, contours);
  structure.section_at(Nanometers{1'000'000}, contours);
  CHECK(contours.loops.size() == 1);
  structure.section_at(Nanometers{2'000'000}, contours);
  CHECK(contours.loops.empty());
  CHECK(contours.points.empty());
  SupportStructure({}).section_at(Nanometers{}, contours);
  CHECK(contours.loops.empty());
}

TEST_CASE("Primitives stay in the order in which they were given") {
  const std::vector<SupportPrimitive> primitives{Ball{{0, 0, 9}, 1}, Ball{{0, 0, 1}, 1}, Ball{{0, 0, 5}, 1}};
  const SupportStructure structure(primitives);
  CHECK(std::ranges::equal(structure.primitives(), primitives));
}

TEST_CASE("Warm sections, and masks with them, allocate nothing") {
  const auto structure = std::make_shared<const SupportStructure>(forest(9));
  const DisplayGeometry display{Pixels{640}, Pixels{640}};
  ContourEngine engine({plate_model(models::gyroid_sphere(10, 6, 24), Elevation(mm(5)), display)}, {display},
                       structure);
  Contours contours;
  CHECK(allocations_when_warm(2, [&] {
          for (Nanometers height{0}; height < Nanometers{26'000'000}; height += Nanometers{300'000}) {
            structure->section_at(height, contours);
            (void)engine.mask_at(height);
          }
        }) == 0);
}

TEST_CASE("Supports are lit in a mask at the size of their sections") {
  const DisplayGeometry display{Pixels{800}, Pixels{800}};
  ContourEngine engine({}, {display}, std::make_shared<const SupportStructure>(forest(9)));
  const Mask& mask = engine.mask_at(Nanometers{3'000'000});
  CHECK(mask.lit_area() == static_cast<double>(mask.lit_pixels()));
  // There are 81 circles of 10 pixels' radius. Counted by pixel centres, each is off by some pixels, and
  // their mean by none.
  CHECK(mask.lit_area() == Approx(81 * 314.159).epsilon(0.02));
}
