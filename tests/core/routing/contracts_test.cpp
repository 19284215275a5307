// Checks that each header of core/routing enforces its requirements.
#include "core/routing/support_loads.hpp"
#include "core/routing/support_solids.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("A foot stands on the plate, and every branch leads down") {
  LitLayers layers;
  layers.begin({Pixels{104}, Pixels{104}, Micrometers{100.0}}, Nanometers{50'000});
  const DisplayGeometry area{Pixels{100}, Pixels{100}, Micrometers{100.0}};
  const ClearanceField field(layers, {-5, 5, -5, 5, 5}, {area, 0.5}, {});
  const SupportSettings settings;
  CHECK(contract_broken_by([&] {
          static_cast<void>(foot_at({0, 0, 1}, 0.5, field, settings));
        }) == "a foot stands on the plate");
  SupportTree tree;
  tree.nodes.push_back({{0, 0, 1}, 1, 5, 0.5});
  tree.nodes.push_back({{0, 0, 2}, SupportNode::kNone, 5, 0.5});
  CHECK(contract_broken_by([&] { thicken_branches(tree, field, settings); }) == "every node leads down");
}
