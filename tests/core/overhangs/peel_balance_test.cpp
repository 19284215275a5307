#include "core/overhangs/peel_balance.hpp"

#include "tests/catch.hpp"
#include "tests/core/text_mask.hpp"

namespace {

// Returns the balance of a body whose layer is a row of 80 pixels.
PeelBalance peel_of_wide_body(double contact_holds) {
  LayerParts parts;
  parts.add_layer(testing::runs_of({std::string(80, '#') + std::string(20, '.')}),
                  testing::runs_of({std::string(100, '.')}));
  PeelBalance peel(contact_holds);
  peel.add_layer(parts);
  return peel;
}

}  // namespace

TEST_CASE("A body is overloaded while half its layer is more than its contacts hold") {
  PeelBalance peel = peel_of_wide_body(15);
  for (int contacts = 0; contacts < 3; ++contacts) {
    CHECK(peel.overloaded(0));
    peel.add_contact({contacts, 0}, 0);
  }
  CHECK_FALSE(peel.overloaded(0));
  peel.settle();
  CHECK(peel.load_pixels(0) == 40.0 / 3);
}

TEST_CASE("A body that stands on the plate is never overloaded") {
  PeelBalance peel = peel_of_wide_body(1);
  peel.stand(0);
  CHECK_FALSE(peel.overloaded(0));
}

TEST_CASE("The place farthest from all contacts is taken, a steep one only if no other is left") {
  PeelBalance peel = peel_of_wide_body(1);
  CHECK_FALSE(peel.take_place(0));
  peel.add_place({{10, 0}, 1, false}, 0);
  peel.add_place({{30, 0}, 1, false}, 0);
  peel.add_place({{79, 0}, 1, true}, 0);
  peel.add_contact({5, 0}, 0);
  for (const std::int32_t column : {30, 10, 79}) {
    const auto place = peel.take_place(0);
    REQUIRE(place);
    CHECK(place->at == SweepPixel{column, 0});
    peel.add_contact(place->at, 0);
  }
  CHECK_FALSE(peel.take_place(0));
}
