// Checks that each header of core/layers checks what it requires.
#include "core/layers/adaptive_layers.hpp"
#include "core/layers/layer_statistics.hpp"
#include "core/layers/layers.hpp"
#include "core/layers/print_layers.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

const std::string kBadThickness = "a layer's thickness is positive and at most kThickestLayer";
const std::string kBadAdaptive = "1 um <= thinnest <= thickest <= kThickestLayer, and the cusp is positive";

// Layers that cannot be printed.
const AdaptiveLayers kUnprintable[] = {
    {Nanometers{999}, Nanometers{50'000}, Nanometers{1'000}},
    {Nanometers{50'001}, Nanometers{50'000}, Nanometers{1'000}},
    {Nanometers{1'000}, kThickestLayer + Nanometers{1}, Nanometers{1'000}},
    {Nanometers{1'000}, Nanometers{50'000}, Nanometers{0}},
};

}  // namespace

TEST_CASE("A layer's thickness must be positive and at most the thickest") {
  const auto layers_of = [](std::int64_t nm) {
    return contract_broken_by([nm] { (void)layers_for(Millimeters{1}, Nanometers{nm}); });
  };
  CHECK(layers_of(kThickestLayer.count()).empty());
  CHECK(layers_of(1'000).empty());
  for (const std::int64_t nm : {std::int64_t{0}, std::int64_t{-1}, kThickestLayer.count() + 1})
    CHECK(layers_of(nm) == kBadThickness);
}

TEST_CASE("PrintLayers takes uniform layers with a thickness, or no layers") {
  CHECK(contract_broken_by([] { PrintLayers(LayerStack{}); }).empty());
  CHECK(contract_broken_by([] { PrintLayers(LayerStack{Nanometers{0}, 1}); }) == "layers have a thickness");
  CHECK(contract_broken_by([] {
          PrintLayers(LayerStack{Nanometers{50'000}, -1});
        }) == "layers have a thickness");
}

TEST_CASE("Adaptive layers require printable bounds and models that are not null") {
  const StandingModel box{std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 1}))};
  for (const AdaptiveLayers& layers : kUnprintable) {
    CHECK(contract_broken_by([&] { (void)next_thickness(box, Nanometers{0}, layers); }) == kBadAdaptive);
    CHECK(contract_broken_by([&] { PrintLayers({box}, layers); }) == kBadAdaptive);
  }
  const AdaptiveLayers good{Nanometers{1'000}, kThickestLayer, Nanometers{1}};
  CHECK(contract_broken_by([&] { (void)next_thickness(box, Nanometers{0}, good); }).empty());
  CHECK(contract_broken_by([&] { PrintLayers({box, StandingModel{}}, good); }) == "no model is null");
}

TEST_CASE("Two series must have the same length to be correlated") {
  const std::vector<double> three{1, 2, 3}, two{1, 2};
  CHECK(contract_broken_by([&] { (void)normalized_correlation(three, three); }).empty());
  CHECK(contract_broken_by([&] { (void)normalized_correlation(three, two); }) ==
        "both series have the same length");
}
