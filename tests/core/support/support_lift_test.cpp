#include "core/support/support_lift.hpp"

#include "tests/catch.hpp"
#include "tests/core/section_fixture.hpp"
#include "tests/models/models.hpp"

using models::together;

namespace {

constexpr Nanometers kLayer{50'000};

Nanometers lift_of(const models::Facets& facets, Nanometers layer = kLayer) {
  return support_lift(HeightIndex(facets), {}, layer);
}

}  // namespace

TEST_CASE("A model that stands on a flat face stays on the plate") {
  CHECK(lift_of(models::box({0, 0, 3}, {10, 10, 20})) == Nanometers{});
  CHECK(lift_of(models::cone(5, 10, 40)) == Nanometers{});
}

TEST_CASE("A model that stands on a point or a round belly is lifted by 5 mm") {
  CHECK(lift_of(models::globe(10, 60, 120)) == Nanometers{5'000'000});
  const std::array<Point, 3> on_its_point{{{0, 0}, {5, 10}, {0, 10}}};
  CHECK(lift_of(models::lathe(on_its_point, 40)) == Nanometers{5'000'000});
}

TEST_CASE("A face holds the model from a tenth of the widest layer on") {
  const auto on_a_stem = [](float side) {
    return together(models::box({-side / 2, -side / 2, 0}, {side / 2, side / 2, 5}),
                    models::box({-10, -10, 5}, {10, 10, 8}));
  };
  CHECK(lift_of(on_a_stem(6.2F)) > Nanometers{});   // face of 38 mm2, widest layer of 400 mm2
  CHECK(lift_of(on_a_stem(6.5F)) == Nanometers{});  // face of 42 mm2
}

TEST_CASE("A model that would tip over is lifted") {
  const auto gallows = [](float arm) {
    return together(models::box({0, 0, 0}, {6, 6, 20}), models::box({0, 0, 20}, {arm, 6, 24}));
  };
  CHECK(lift_of(gallows(10)) == Nanometers{});
  CHECK(lift_of(gallows(30)) > Nanometers{});
}

TEST_CASE("The lift is a whole number of layers, rounded up") {
  CHECK(lift_of(models::globe(10, 60, 120), Nanometers{30'000}) == Nanometers{5'010'000});
  CHECK(lift_of(models::globe(10, 60, 120), Nanometers{100'000}) == Nanometers{5'000'000});
}
