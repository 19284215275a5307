// Checks that each header of core/clearance enforces its requirements.
#include "core/clearance/clearance_field.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("A field refuses levels that it does not have") {
  LitLayers layers;
  layers.begin({Pixels{104}, Pixels{104}, Micrometers{100.0}}, Nanometers{50'000});
  const DisplayGeometry area{Pixels{100}, Pixels{100}, Micrometers{100.0}};
  const ClearanceField field(layers, {-5, 5, -5, 5, 5}, {area, 0.5}, {});
  CHECK(contract_broken_by([&] { static_cast<void>(field.level(field.levels())); }) ==
        "the level is one of the field's");
}
