// Checks that each header of core/plate enforces its requirements.
#include "core/plate/plate_collision.hpp"
#include "core/plate/plate_packing.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

TEST_CASE("PlatePacking finds room only for rectangles with a width and a depth") {
  PlatePacking packing(Pixels{10}, Pixels{10}, Pixels{1});
  CHECK(contract_broken_by([&] { (void)packing.find_room(1, 1); }).empty());
  CHECK(contract_broken_by([&] { (void)packing.find_room(0, 1); }) ==
        "the rectangle has a width and a depth");
  CHECK(contract_broken_by([&] { (void)packing.find_room(1, -1); }) ==
        "the rectangle has a width and a depth");
}

TEST_CASE("Models collide in layers that have a thickness") {
  const PlacedModel box{{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 1}))}, {0, 0}};
  for (const std::int64_t nm : {0, -1})
    CHECK(contract_broken_by([&] { (void)find_collision(box, box, {}, Nanometers{nm}); }) ==
          "a layer has a thickness");
}
