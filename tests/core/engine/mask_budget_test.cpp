#include "core/geometry/mask_budget.hpp"

#include "core/contour/contour_offset.hpp"
#include "core/engine/contour_engine.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"
#include "tests/core/random_contours.hpp"
#include "tests/core/warm_allocations.hpp"
#include "tests/models/damage.hpp"
#include "tests/models/models.hpp"

namespace {

ContourEngine engine_of(models::Facets facets, Micrometers growth) {
  const Point center = bounds_of(facets).center();
  return engine_for(std::move(facets), {.display = kCoarseDisplay, .compensation = {.growth = growth}},
                    center);
}

models::Facets dense_soup(std::size_t count) {
  models::Dice dice(7);
  return models::soup(count, 10, dice);
}

// Returns a plate with n by n square holes and walls of 10 um between them.
Contours lattice(int n) {
  const double pitch = 0.25, wall = 0.01, side = n * pitch + wall;
  std::vector<Loop> loops{rectangle(0, 0, side, side)};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      loops.push_back(
          turned(rectangle(i * pitch + wall, j * pitch + wall, (i + 1) * pitch, (j + 1) * pitch)));
    }
  }
  return contours_from(loops);
}

double steps_to_move(const Contours& contours, double distance) {
  ContourOffset offset;
  Contours moved;
  MaskBudget budget;
  REQUIRE(offset.offset(contours, Millimeters{distance}, moved, budget));
  return static_cast<double>(budget.steps());
}

}  // namespace

TEST_CASE("A mask that overruns its budget is abandoned, and the next one is correct", "[long]") {
  for (const double growth : {0.0, 40.0, -40.0}) {
    CAPTURE(growth);
    ContourEngine engine = engine_of(dense_soup(3000), Micrometers{growth});
    const Nanometers height{7'000'000}, lower{100'000};
    // Only sides that are moved are cut where they cross, which makes them more than 5000.
    MaskBudget few_sides(std::nullopt, growth == 0.0 ? 500 : 5000), no_time(MaskBudget::Clock::now());
    CHECK(engine.mask_within(height, few_sides) == nullptr);
    CHECK(few_sides.overrun());
    CHECK(engine.mask_within(height, no_time) == nullptr);
    ContourEngine fresh = engine_of(dense_soup(3000), Micrometers{growth});
    CHECK(engine.mask_at(lower) == fresh.mask_at(lower));
    MaskBudget enough;
    const Mask* mask = engine.mask_within(height, enough);
    REQUIRE(mask != nullptr);
    CHECK(*mask == fresh.mask_at(height));
  }
}

TEST_CASE("The search for partners of open ends stops when the budget is overrun") {
  // Facets without neighbours: each end is compared with hundreds of others.
  ContourEngine engine = engine_of(dense_soup(20'000), Micrometers{});
  const auto steps_within = [&engine](MaskBudget::Clock::duration time) {
    MaskBudget budget(MaskBudget::Clock::now() + time);
    CHECK(engine.mask_within(Nanometers{10'000'000}, budget) == nullptr);
    return budget.steps();
  };
  // Some 15,000 segments are counted, and the clock has been looked at by then.
  CHECK(steps_within({}) < 20'000);
  // With enough time, however slow the machine is, the ends are compared.
  std::uint64_t steps = 0;
  for (MaskBudget::Clock::duration time = std::chrono::milliseconds{50};
       steps < 20'000 && time < std::chrono::seconds{10}; time *= 2)
    steps = steps_within(time);
  CHECK(steps > 20'000);
}

TEST_CASE("A sound mask takes one step for each side plus those of an offset, the same every time") {
  ContourEngine engine = engine_of(models::gyroid_sphere(10, 5, 24), Micrometers{});
  MaskBudget one, other;
  REQUIRE(engine.mask_within(Nanometers{9'000'000}, one) != nullptr);
  REQUIRE(engine.mask_within(Nanometers{9'000'000}, other) != nullptr);
  CHECK(one.steps() == other.steps());
  CHECK(one.steps() <= 2 * engine.intersecting_facets());
}

TEST_CASE("Four times the holes of a lattice take four times the steps to move") {
  for (const double distance : {-0.004, -0.1, 0.002}) {
    const double small = steps_to_move(lattice(12), distance);
    const double large = steps_to_move(lattice(48), distance);
    CAPTURE(distance, small, large);
    CHECK(large < 16 * 1.5 * small);  // holes at the edge of a lattice have fewer neighbours
  }
}

TEST_CASE("Twice the loops in each other take twice the steps") {
  const auto nested = [](int count) {
    std::vector<Loop> loops;
    for (int i = 1; i <= count; ++i)
      loops.push_back(i % 2 == 0 ? turned(circle({0, 0}, i * 0.1, 90)) : circle({0, 0}, i * 0.1, 90));
    return contours_from(loops);
  };
  for (const double distance : {-0.01, 0.01})
    CHECK(steps_to_move(nested(400), distance) < 4.1 * steps_to_move(nested(100), distance));
}

TEST_CASE("A mask of overlapping solids allocates nothing once warm") {
  models::Facets other = models::sphere(6, 14);
  models::translate(other, 5, 1, 2);
  const models::Facets facets = models::together(models::sphere(7, 14), other);
  for (const double growth : {0.0, -40.0}) {
    ContourEngine engine = engine_of(facets, Micrometers{growth});
    CHECK(allocations_when_warm(2, [&engine] {
            for (int i = 1; i < 12; ++i)
              (void)engine.mask_at(Nanometers{i * 1'000'000});
          }) == 0);
  }
}
