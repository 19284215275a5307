#include "core/orientation/nearly_level_base.hpp"

#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

constexpr Nanometers kLayer{50'000};

std::optional<LevelBase> base_of(models::Facets facets, double tilt_deg) {
  orient(facets, {.x_deg = 0.6 * tilt_deg, .y_deg = 0.8 * tilt_deg});
  return nearly_level_base(facets, {}, kLayer);
}

}  // namespace

TEST_CASE("A flat base up to five degrees off the level is found with its tilt") {
  const models::Facets box = models::box({0, 0, 0}, {20, 15, 10});
  const models::Facets bracket = models::together(box, models::box({0, 0, 5}, {4, 15, 40}));
  for (const models::Facets& facets : {box, bracket, models::cone(8, 12, 48)}) {
    for (const double tilt_deg : {0.5, 1.0, 3.0, 4.9}) {
      const std::optional<LevelBase> base = base_of(facets, tilt_deg);
      REQUIRE(base);
      // Turns about two axes one after the other are a little more or less than one turn.
      CHECK(base->tilt_deg == testing::Approx(tilt_deg).epsilon(0.01));
    }
    CHECK_FALSE(base_of(facets, 6));
    CHECK_FALSE(base_of(facets, 0));
  }
}

TEST_CASE("A model without a base that bears it has no nearly level base") {
  CHECK_FALSE(base_of(models::globe(8, 40, 80), 3));
  // A tower that would fall over, and a face far smaller than what it would carry.
  const models::Facets leaning =
      models::together(models::box({0, 0, 0}, {4, 4, 4}), models::box({3, 0, 3}, {30, 4, 7}));
  CHECK_FALSE(base_of(leaning, 3));
  const models::Facets top =
      models::together(models::box({-1, -1, 0}, {1, 1, 8}), models::box({-10, -10, 7}, {10, 10, 9}));
  CHECK_FALSE(base_of(top, 3));
}
