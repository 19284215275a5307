// Checks that each header of core/overhangs enforces its requirements.
#include "core/overhangs/bearing_group.hpp"
#include "core/overhangs/carried_supports.hpp"
#include "core/overhangs/layer_parts.hpp"
#include "core/overhangs/overhang_sweep.hpp"
#include "core/overhangs/peel_balance.hpp"
#include "core/overhangs/surfaces_beneath.hpp"
#include "core/overhangs/sweep_grid.hpp"
#include "core/overhangs/underside.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/core/overhangs/held_fixture.hpp"

TEST_CASE("A sweep needs models that are not null, and pixels with a size") {
  SupportRequest request = testing::held_request(models::box({0, 0, 0}, {1, 1, 1}), 0);
  testing::CountingObserver observer;
  const auto sweep = [&] { (void)find_overhangs(request, observer); };
  CHECK(contract_broken_by(sweep).empty());
  request.display.pixel_pitch = Micrometers{};
  CHECK(contract_broken_by(sweep) == "every model is there, and a pixel has a size");
  request.display.pixel_pitch = Micrometers{50.0};
  request.models.front().model = nullptr;
  CHECK(contract_broken_by(sweep) == "every model is there, and a pixel has a size");
  CHECK(contract_broken_by([&] { (void)surfaces_beneath(request.models, request.display, {}); }) ==
        "every model is there");
}

TEST_CASE("A search for supports needs a model that can be swept") {
  const auto search = [](const std::shared_ptr<const HeightIndex>& model) {
    return contract_broken_by([&] { (void)carries_supports(model, {}); });
  };
  const std::string sentence = "the model is there and no higher than can be swept";
  CHECK(search(nullptr) == sentence);
  CHECK(search(std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 3001}))) == sentence);
  CHECK(search(std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 2999}))).empty());
}

TEST_CASE("A sweep refuses models that need more layers than it can number") {
  const SupportRequest request = testing::held_request(models::box({0, 0, 0}, {1, 1, 3001}), 0);
  testing::CountingObserver observer;
  CHECK(contract_broken_by([&] { (void)find_overhangs(request, observer); }) ==
        "the models are no higher than can be swept");
}

TEST_CASE("A sweep's grid needs a build area with a size") {
  CHECK(contract_broken_by([] { (void)sweep_grid(testing::kHeldDisplay); }).empty());
  CHECK(contract_broken_by([] {
          (void)sweep_grid({Pixels{0}, Pixels{1}, Micrometers{50.0}});
        }) == "the build area has a size");
}

TEST_CASE("LayerParts and PeelBalance take consecutive layers of the same size") {
  MaskRuns small, large;
  small.extract(Mask(Pixels{4}, Pixels{4}));
  large.extract(Mask(Pixels{4}, Pixels{5}));
  LayerParts parts;
  CHECK(contract_broken_by([&] { parts.add_layer(small, small); }).empty());
  CHECK(contract_broken_by([&] { parts.add_layer(small, large); }) ==
        "the layer beneath is the previous one and has the same size");
  parts.add_layer(small, small);
  CHECK(contract_broken_by([&] { (void)parts.part_at(small, 1, 1); }) ==
        "the pixel is lit in the last layer");
  CHECK(contract_broken_by([] { PeelBalance({0, 1}, 0); }) == "a contact holds something");
  const PeelBalance peel({1, 1}, 0);
  CHECK(contract_broken_by([&] {
          (void)peel.overloaded({0, {1, 0, 0}});
        }) == "the body belongs to a part of the layer");
}

TEST_CASE("A lever needs a bearing") {
  CHECK(contract_broken_by([] { (void)BearingGroup().lever({1, 0, 0}); }) == "a lever needs a bearing");
}

TEST_CASE("Underside takes only lit pixels as contacts") {
  Underside underside(sweep_grid(testing::kHeldDisplay));
  CHECK(contract_broken_by([&] { underside.hold({1, 1}, 1); }) == "the contact is lit");
}
