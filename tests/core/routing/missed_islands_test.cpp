#include "core/routing/missed_islands.hpp"

#include "core/routing/support_layout.hpp"
#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"

namespace {

// Returns a block and a wall in the air that covers less than half of each of its pixels, so that no pixel of
// a sweep has its middle in the wall.
SupportRequest beside_thin_wall() {
  SupportRequest request = testing::held_request(
      models::together(models::box({-2, -2, 0}, {2, 2, 3}), models::box({5.003F, -2, 2}, {5.022F, 2, 4})), 0);
  request.printed.thicknesses.assign(80, Nanometers{50'000});
  return request;
}

}  // namespace

TEST_CASE("An island that only the print's masks show is held, or told as unheld") {
  const SupportRequest request = beside_thin_wall();
  CHECK(testing::contacts_of(request).empty());
  const std::vector<SupportContact> missed = missed_islands(request, {}).missed;
  REQUIRE(missed.size() == 1);
  CHECK(std::fabs(missed.front().place.x - 5.0125) < 0.05);
  CHECK(std::fabs(missed.front().place.z - 2) < 1e-4);
  const Supports supports = make_supports(request).value();
  CHECK(supports.contacts.size() + supports.unheld.size() >= 1);
  CHECK(missed_islands(request, supports).missed.empty());
}

TEST_CASE("Masks without islands, too faint ones and unknown layers give no contacts") {
  SupportRequest request = beside_thin_wall();
  request.printed.least_grey = 128;
  CHECK(missed_islands(request, {}).missed.empty());
  request.printed = {};
  CHECK(missed_islands(request, {}).missed.empty());
}

TEST_CASE("Islands that the bottom exposures join to the plate are listed as resting") {
  SupportRequest request = testing::held_request(
      models::together(models::box({-2, -2, 0}, {2, 2, 3}), models::box({5, -2, 0.15F}, {7, 2, 3})), 0);
  request.printed.thicknesses.assign(60, Nanometers{50'000});
  const Supports supports = make_supports(request).value();
  CHECK(supports.contacts.empty());
  REQUIRE(supports.resting.size() == 1);
  CHECK(supports.resting[0].place.z == testing::Approx(0.15));
  CHECK(std::fabs(supports.resting[0].place.x - 6) < 0.1);
  request.settings.closed_gap = Millimeters{0.1};
  CHECK(make_supports(request).value().resting.empty());
}
