// Checks that each header of core/analysis enforces its requirements.
#include "core/analysis/island_finder.hpp"
#include "core/analysis/print_analysis.hpp"
#include "core/analysis/void_finder.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"

TEST_CASE("PrintAnalysis takes only masks of the display's size") {
  const DisplayGeometry display{Pixels{8}, Pixels{6}, Micrometers{50.0}};
  PrintAnalysis analysis(display);
  CHECK(contract_broken_by([&] { analysis.add_layer(Mask(Pixels{8}, Pixels{6}), {}); }).empty());
  const std::string size = "the mask has the display's size";
  CHECK(contract_broken_by([&] { analysis.add_layer(Mask(Pixels{8}, Pixels{7}), {}); }) == size);
  CHECK(contract_broken_by([&] { analysis.add_layer(Mask(Pixels{7}, Pixels{6}), {}); }) == size);
}

TEST_CASE("IslandFinder takes only the runs of masks of the same size") {
  MaskRuns layer, taller;
  layer.extract(Mask(Pixels{4}, Pixels{4}));
  taller.extract(Mask(Pixels{4}, Pixels{5}));
  IslandFinder finder;
  CHECK(contract_broken_by([&] { (void)finder.find(layer, layer, {1, 0}); }).empty());
  CHECK(contract_broken_by([&] { (void)finder.find(layer, taller, {1, 0}); }) == "all masks have one size");
}

TEST_CASE("VoidFinder takes only the runs of masks of the same size") {
  MaskRuns layer, taller;
  layer.extract(Mask(Pixels{4}, Pixels{4}));
  taller.extract(Mask(Pixels{4}, Pixels{5}));
  VoidFinder finder;
  (void)finder.add_layer(layer, {0, Nanometers{1}});
  CHECK(contract_broken_by([&] { (void)finder.add_layer(layer, {1, Nanometers{1}}); }).empty());
  CHECK(contract_broken_by([&] {
          (void)finder.add_layer(taller, {1, Nanometers{1}});
        }) == "all masks have one size");
}
