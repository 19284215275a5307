#include "core/overhangs/surface_probe.hpp"

#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"

using namespace contourd;

TEST_CASE("A surface that looks down is found at its height above the plate, one that looks up is not") {
  const SupportRequest request = testing::held_request(models::box({-2, -2, 0}, {2, 2, 1}), 5);
  const SurfaceProbe probe(request.models, request.display);
  const auto surface = probe.beneath({1, 1}, {4.9, 5.1}, 0.2);
  REQUIRE(surface);
  CHECK(surface->z_mm == 5);
  CHECK(surface->outward == Direction{0, 0, -1});
  CHECK_FALSE(probe.beneath({1, 1}, {5.9, 6.1}, 0.2));
  CHECK_FALSE(probe.beneath({3, 1}, {4.9, 5.1}, 0.2));
  CHECK(probe.beneath({2.1, 1}, {4.9, 5.1}, 0.2));
}
