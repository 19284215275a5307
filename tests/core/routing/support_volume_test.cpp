#include "core/routing/support_volume.hpp"

#include <stop_token>

#include "tests/catch.hpp"
#include "tests/core/routing/supports_fixture.hpp"

namespace {

// Returns the volume beside a slab from 8 to 12 mm above the plate, as a sweep sees it.
double volume_of(std::vector<SupportPrimitive> primitives, const std::stop_token& stop = {}) {
  LitLayers slab;
  stack({models::box({-5, -5, 8}, {5, 5, 12})}, kBuildArea, slab);
  return volume_beside_models_mm3(std::make_shared<const SupportStructure>(std::move(primitives)), slab,
                                  stop);
}

}  // namespace

// A disc of 1 mm radius covers 314 of the sweep's pixels: counting centres misses its area by less than 2 %.
TEST_CASE("A pillar's volume is the part of it outside the model") {
  CHECK(volume_of({Frustum{{0, 0, 0}, {0, 0, 10}, 1, 1}}) ==
        testing::Approx(8 * std::numbers::pi).epsilon(0.02));
}

TEST_CASE("Overlapping pieces of a support count once") {
  const Frustum pillar{{0, 0, 0}, {0, 0, 6}, 1, 1};
  CHECK(volume_of({pillar, pillar, Ball{{0, 0, 5}, 1}}) ==
        testing::Approx(6 * std::numbers::pi).epsilon(0.02));
}

TEST_CASE("A foot that tapers has the volume of its sections") {
  // Five sections: the midpoint rule adds 0.4 % to the pixels' error. That error is the same in all four
  // quarters of a disc centred on a pixel's corner, so the foot stands beside a corner. Sections 0.025 mm off
  // their middles would be off by 5 %.
  const double mm3 = std::numbers::pi / 3 * 1 * (0.5 * 0.5 + 0.5 * 2 + 2 * 2);
  CHECK(volume_of({Frustum{{0.033, 0.017, 0}, {0.033, 0.017, 1}, 2, 0.5}}) ==
        testing::Approx(mm3).epsilon(0.02));
}

TEST_CASE("A stopped volume computation does not go on") {
  std::stop_source stop;
  stop.request_stop();
  CHECK(volume_of({Frustum{{0, 0, 0}, {0, 0, 6}, 1, 1}}, stop.get_token()) == 0);
}
