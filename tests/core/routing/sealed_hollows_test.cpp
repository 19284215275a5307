#include "core/routing/sealed_hollows.hpp"

#include <vector>

#include "tests/catch.hpp"
#include "tests/core/routing/supports_fixture.hpp"

using models::together;

namespace {

// Returns a room of 12 mm inside and 8 mm high, from 6 to 14 mm above the plate, with walls of 2 mm. Its
// right wall ends `slit_mm` below the ceiling, and without a floor its walls stand on the plate.
models::Facets walled_room(float slit_mm, bool has_floor = true) {
  const float low = has_floor ? 4 : 0;
  models::Facets room =
      together({models::box({-8, -8, 13.9F}, {8, 8, 16}), models::box({-8, -8, low}, {-6, 8, 14}),
                models::box({6, -8, low}, {8, 8, 14 - slit_mm}), models::box({-8, -8, low}, {8, -6, 14}),
                models::box({-8, 6, low}, {8, 8, 14})});
  return has_floor ? together(room, models::box({-8, -8, 4}, {8, 8, 6})) : room;
}

bool is_sealed(const models::Facets& facets, const PlatePoint& contact) {
  LitLayers layers;
  testing::stack({facets}, kBuildArea, layers);
  return SealedHollows(layers).holds(contact);
}

}  // namespace

TEST_CASE("A room is sealed unless a slit or the plate opens it") {
  CHECK(is_sealed(walled_room(0), {0, 0, 13.9}));
  CHECK(is_sealed(walled_room(0), {5, 5, 13.9}));
  CHECK_FALSE(is_sealed(walled_room(0.4F), {0, 0, 13.9}));
  CHECK_FALSE(is_sealed(walled_room(0, false), {0, 0, 13.9}));
  // Beneath the room, and beside it.
  CHECK_FALSE(is_sealed(walled_room(0), {0, 0, 4}));
  CHECK_FALSE(is_sealed(walled_room(0), {10, 0, 4}));
}

TEST_CASE("A hollow in a solid inside an open room is sealed, and the room is not") {
  const models::Facets box =
      together(models::box({-3, -3, 6}, {3, 3, 12}), models::inverted(models::box({-2, -2, 7}, {2, 2, 11})));
  const models::Facets both = together(walled_room(0.4F), box);
  CHECK(is_sealed(both, {0, 0, 11}));
  CHECK_FALSE(is_sealed(both, {5, 0, 13.9}));
}

TEST_CASE("The top of a dome in a hollow is bridged, the middle of a level ceiling is not") {
  models::Facets dome = models::globe(8, 80, 160);
  models::translate(dome, 0, 0, 12);
  const models::Facets domed = together(models::box({-12, -12, 0}, {12, 12, 24}), models::inverted(dome));
  const auto is_bridged = [](const models::Facets& facets, const SupportContact& contact) {
    LitLayers layers;
    testing::stack({facets}, kBuildArea, layers);
    return SealedHollows(layers).is_bridged(contact, Millimeters{1.5});
  };
  const auto at = [](double x, double z, ContactCause cause = ContactCause::Overhang) {
    return SupportContact{{x, 0, z}, {0, 0, -1}, cause, 1};
  };
  CHECK(is_bridged(domed, at(0, 19.98)));
  CHECK(is_bridged(domed, at(1, 19.92)));
  CHECK_FALSE(is_bridged(domed, at(0, 19.98, ContactCause::Island)));
  CHECK_FALSE(is_bridged(walled_room(0), at(0, 13.9)));
  CHECK(is_bridged(walled_room(0), at(5, 13.9)));
  CHECK_FALSE(is_bridged(walled_room(0.4F), at(5, 13.9)));  // not in a sealed hollow
}
