// Tests the weakest bond of pixels that get less than full light.
#include "core/cure/layer_bonds.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/catch.hpp"

namespace {

constexpr Nanometers kThick{50'000};
constexpr double kDp = 150;                        // um
const double kFull = std::exp(100 / kDp);          // dose over Ec that cures two layers
const double kThroughLayer = std::exp(-50 / kDp);  // share of the light below a layer
constexpr CureSettings kSettings{.curve = {Micrometers{kDp}, MillijoulesPerCm2{8}}};

// The light of one pixel in a layer, from the plate up.
struct Lit {
  float share;
  std::uint8_t covered = 255;
  bool peeled = true;
};

std::optional<LayerBond> weakest_bond(const std::vector<Lit>& print,
                                      const CureSettings& settings = kSettings) {
  std::vector<LayerDose> layers;
  for (const Lit& lit : print)
    layers.push_back({kThick * static_cast<std::int64_t>(layers.size() + 1), kThick,
                      MillijoulesPerCm2{8 * kFull}, lit.peeled});
  CuredLayers cured(settings, 1);
  LayerBonds bonds(settings, layers, 1);
  for (std::size_t layer = print.size(); layer-- > 0;) {
    const std::array share{print[layer].share};
    const std::array covered{print[layer].covered};
    bonds.add_layer(layer, {covered, share, cured.add_layer(layers[layer], share)});
  }
  return bonds.weakest();
}

}  // namespace

TEST_CASE("A pixel with less than full light bonds with less") {
  const auto bond = weakest_bond({{1}, {1}, {0.6F}, {1}});
  REQUIRE(bond);
  CHECK(bond->layer == 2);
  CHECK(bond->dose == Approx(0.6 * kFull * kThroughLayer));
  CHECK(bond->dose < 1);
  CHECK_FALSE(weakest_bond({{1}, {1}, {1}}));
}

TEST_CASE("Pixels that the model does not fill in both layers have no bond") {
  CHECK_FALSE(weakest_bond({{1}, {0.6F, 254}, {1}}));
  CHECK_FALSE(weakest_bond({{0, 0}, {0.6F}, {1}}));
  // Light of 0.4 alone solidifies nothing.
  CHECK_FALSE(weakest_bond({{1}, {0.4F}}));
}

TEST_CASE("Layers that light from above solidifies are bonded by that light") {
  const auto bond = weakest_bond({{0}, {0}, {1}, {1}});
  REQUIRE(bond);
  CHECK(bond->layer == 1);
  const double all = kFull * kThroughLayer * (1 + kThroughLayer);  // at the top of layer 1
  CHECK(bond->dose == Approx(all * kThroughLayer));
  // A dark layer above one that was solid hangs on it only as far as light reaches through.
  const auto over_solid = weakest_bond({{1}, {0}, {1}}, {.curve = kSettings.curve, .peel_memory = 0});
  REQUIRE(over_solid);
  CHECK(over_solid->dose == Approx(kFull * kThroughLayer * kThroughLayer));
}

TEST_CASE("A corner hangs on its neighbours, and a thin wall has none that hold it") {
  // Light that spreads: the outermost pixels get 0.7, and those in the corners half.
  constexpr std::size_t kSide = 4;
  const auto weakest = [](std::size_t wall) {
    std::vector<float> share(kSide * kSide);
    std::vector<std::uint8_t> covered(kSide * kSide);
    for (std::size_t y = 0; y < kSide; ++y) {
      for (std::size_t x = 0; x < wall; ++x) {
        const bool at_side = x == 0 || x + 1 == wall, at_end = y == 0 || y + 1 == kSide;
        share[y * kSide + x] = at_side && at_end ? 0.52F : at_side || at_end ? 0.7F : 1;
        covered[y * kSide + x] = 255;
      }
    }
    const std::vector<LayerDose> layers{{kThick, kThick, MillijoulesPerCm2{8 * kFull}, true},
                                        {2 * kThick, kThick, MillijoulesPerCm2{8 * kFull}, true}};
    CuredLayers cured(kSettings, share.size());
    LayerBonds bonds(kSettings, layers, kSide);
    for (const std::size_t layer : {1U, 0U})
      bonds.add_layer(layer, {covered, share, cured.add_layer(layers[layer], share)});
    return bonds.weakest().value().dose;
  };
  CHECK(weakest(4) == Approx(kFull * kThroughLayer));
  CHECK(weakest(1) == Approx(0.7 * kFull * kThroughLayer));
}

TEST_CASE("Light of layers without a peel between them bonds them together") {
  const auto bond = weakest_bond({{1}, {0.6F, 255, false}, {0.6F}, {1}});
  REQUIRE(bond);
  CHECK(bond->layer == 1);
  CHECK(bond->dose == Approx(0.6 * kFull * kThroughLayer * (1 + kThroughLayer)));
}

TEST_CASE("A dead zone takes its part of the light that bonds") {
  CureSettings settings = kSettings;
  settings.dead_zone = Micrometers{12};
  const auto bond = weakest_bond({{1}, {0.8F}, {1}}, settings);
  REQUIRE(bond);
  CHECK(bond->dose == Approx(0.8 * kFull * kThroughLayer * std::exp(-12 / kDp)));
}
