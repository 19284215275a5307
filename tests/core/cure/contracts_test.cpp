// Tests that the functions of core/cure check their requirements.
#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/cure/cure_comparison.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/cure/cured_part.hpp"
#include "core/cure/dark_copies.hpp"
#include "core/cure/layer_bonds.hpp"
#include "core/cure/pixel_light.hpp"
#include "core/cure/surface_rays.hpp"
#include "core/cure/underside_dimming.hpp"
#include "core/cure/underside_light.hpp"
#include "core/cure/working_curve.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/models/models.hpp"

namespace {

const WorkingCurve kResinCurve{Micrometers{150}, MillijoulesPerCm2{8}};
constexpr Nanometers kThickness{50'000};

LayerDose layer(int number) {
  return {kThickness * (number + 1), kThickness, MillijoulesPerCm2{16}};
}

}  // namespace

TEST_CASE("A working curve requires positive values and doses that are not negative") {
  CHECK(contract_broken_by([] { (void)kResinCurve.depth_of(MillijoulesPerCm2{0}); }).empty());
  CHECK(contract_broken_by([] { (void)kResinCurve.depth_of(MillijoulesPerCm2{-1}); }) ==
        "a dose is not negative");
  const std::string positive = "a working curve has a positive penetration depth and critical dose";
  CHECK(contract_broken_by([] { (void)WorkingCurve{}.dose_for(Micrometers{1}); }) == positive);
  CHECK(contract_broken_by([] { (void)WorkingCurve{}.depth_of(MillijoulesPerCm2{1}); }) == positive);
}

TEST_CASE("The laws of a working curve require quantities that can be") {
  CHECK(contract_broken_by([] { (void)curve_of_ingredients(0, 1, MillijoulesPerCm2{1}); }) ==
        "absorptivity, concentration and dose are positive");
  CHECK(contract_broken_by([] { (void)at_temperature(kResinCurve, {}, -300); }) ==
        "temperatures are above absolute zero");
  const std::string positive = "irradiances are positive";
  CHECK(contract_broken_by([] {
          (void)dead_zone_at(Micrometers{30}, MilliwattsPerCm2{0}, MilliwattsPerCm2{1});
        }) == positive);
  CHECK(contract_broken_by([] {
          (void)at_irradiance(kResinCurve, {MilliwattsPerCm2{1}, 0.5}, MilliwattsPerCm2{0});
        }) == positive);
}

TEST_CASE("Spread light requires Gaussians with a width and a share, and a picture of its size") {
  for (const PixelLight::Gaussian bad : {PixelLight::Gaussian{0, 1}, {17, 1}, {1, 0}})
    CHECK(contract_broken_by([bad] { LightSpread({{bad}}, 2, 2); }) ==
          "a Gaussian has a width of at most 16 pixels and a share");
  CHECK(contract_broken_by([] {
          std::array<float, 3> picture{};
          LightSpread({}, 2, 2).apply(picture);
        }) == "the picture has the size that was given");
}

TEST_CASE("A wall requires a brighter pixel that is solid beside a darker one that is not") {
  const std::string falls = "the dose falls below the least between the pixels";
  CHECK(contract_broken_by([] { (void)wall_between(1, 0.5, 1); }).empty());
  CHECK(contract_broken_by([] { (void)wall_between(0.9, 0.5, 1); }) == falls);
  CHECK(contract_broken_by([] { (void)wall_between(2, 1, 1); }) == falls);
}

TEST_CASE("Cured layers require possible settings, and layers from the top down with light for each pixel") {
  CHECK(contract_broken_by([] { CuredLayers({}, 1); }) == "the working curve has positive values");
  CHECK(contract_broken_by([] { CuredLayers({.curve = kResinCurve, .peel_memory = 1.5}, 1); }) ==
        "the memory is a share, and the losses are not negative");
  CuredLayers cured({.curve = kResinCurve}, 1);
  const std::array light{1.0F};
  (void)cured.add_layer(layer(3), light);
  CHECK(contract_broken_by([&] { (void)cured.add_layer(layer(4), light); }) ==
        "layers are added from the top down");
  CHECK(contract_broken_by([&] { (void)cured.add_layer(layer(2), {}); }) ==
        "each pixel has a share of the light");
}

TEST_CASE("Lines through a surface require models that are not null") {
  const DisplayGeometry display{Pixels{4}, Pixels{4}};
  PlateModel missing;
  missing.copies.push_back(PixelMap::true_scale(display, {0, 0}));
  CHECK(contract_broken_by([&] {
          StopCheck never;
          (void)cross_surface({&missing, 1}, {RayAxis::Z, {0, 0, 4, 4}, {}}, never);
        }) == "no null pointers");
}

TEST_CASE("A comparison requires rising layers, all of which are added from the top down") {
  const DisplayGeometry display{Pixels{4}, Pixels{4}};
  const std::array layers{layer(0), layer(1)}, falling{layer(1), layer(0)};
  const PixelWindow pixel{0, 0, 1, 1};
  CHECK(contract_broken_by([&] { CureComparison({}, {}, display, pixel, falling); }) == "the layers rise");
  const CuredLayers cured({.curve = kResinCurve}, 1);
  const std::array dose{0.0F};
  CureComparison comparison({}, {}, display, pixel, layers);
  const std::string next = "the layer is the next one below, with a dose for each pixel";
  CHECK(contract_broken_by([&] { comparison.add_layer(0, cured, dose); }) == next);
  CHECK(contract_broken_by([&] { comparison.add_layer(1, cured, {}); }) == next);
  comparison.add_layer(1, cured, dose);
  CHECK(contract_broken_by([&] { (void)comparison.figures(); }) == "all layers were added");
}

TEST_CASE("Copies are left dark from layers of a print on, later ones from no lower layer") {
  const DisplayGeometry display{Pixels{40}, Pixels{40}, Micrometers{50}};
  const auto box = std::make_shared<const HeightIndex>(models::box({0, 0, 0}, {1, 1, 0.1F}));
  const PixelMap place = PixelMap::true_scale(display, {0.5, 0.5});
  const std::vector<PlateModel> two{{{box}, {place, place}}};
  ContourEngine engine(two, {.display = display});
  const std::array layers{layer(0), layer(1)};
  const auto leave = [&](const std::vector<DarkCopy>& dark) {
    return contract_broken_by([&] { leave_dark(dark, {layers}, engine, nullptr); });
  };
  const std::string order = "layers from which on copies are dark are layers of the print, and do not fall";
  CHECK(leave({{0, 0, 0}, {0, 1, 2}}).empty());
  CHECK(leave({{0, 0, 1}, {0, 1, 0}}) == order);
  CHECK(leave({{0, 0, 3}}) == order);
  CHECK(leave({{0, 2, 1}}) == "there is such a copy");
  CHECK(contract_broken_by([&] { (void)CutLayers{layers}.height_of(2); }) ==
        "there is such a layer, and each has a height or none");
  UndersideDimming undersides(two, nullptr, {.display = display},
                              {.layers = {layers.begin(), layers.end()},
                               .resin = {.curve = kResinCurve},
                               .mask_budget = std::chrono::hours(1)});
  CHECK(contract_broken_by([&] { undersides.exclude(1, 0, nullptr, 1); }) == "there is such a copy");
  undersides.exclude(0, 0, nullptr, 1);
  CHECK(contract_broken_by([&] { undersides.exclude(0, 1, nullptr, 0); }) ==
        "the layer is one of the print's, and not beneath those of other exclusions");
}

TEST_CASE("Bonds between layers require layers of the print, with light for each pixel") {
  const std::array layers{layer(0)};
  LayerBonds bonds({.curve = kResinCurve}, layers, 1);
  const std::string known = "the layer is one of the print's, with light for each pixel of whole rows";
  const std::array<std::uint8_t, 1> covered{255};
  const std::array light{1.0F};
  CHECK(contract_broken_by([&] { (void)LayerBonds({.curve = kResinCurve}, layers, 0); }) ==
        "a layer has pixels");
  CHECK(contract_broken_by([&] { bonds.add_layer(1, {covered, light, light}); }) == known);
  CHECK(contract_broken_by([&] { bonds.add_layer(0, {covered, light, {}}); }) == known);
  CHECK(contract_broken_by([&] { bonds.add_layer(0, {covered, light, light}); }).empty());
}

TEST_CASE("An underside's light requires a layer that keeps all of it") {
  const std::array doses{0.5, 0.5};
  CHECK(contract_broken_by([&] { (void)underside_light(doses, {}, 2); }) ==
        "a layer is left that gets all its light");
}

TEST_CASE("The range of a model's entries rises") {
  ModelEntries entries(PixelWindow{0, 0, 2, 2});
  MaskBudget budget(MaskBudget::Clock::now() + std::chrono::hours(1));
  const auto rise_to = [&](double above_mm, double up_to_mm) {
    return contract_broken_by([&] { entries.rise_to({}, {above_mm, up_to_mm}, up_to_mm, budget); });
  };
  entries.rise_to({}, {1, 2}, 2, budget);
  CHECK(rise_to(1, 2).empty());
  CHECK(rise_to(0.5, 2) == "the range rises");
  CHECK(rise_to(1, 1.5) == "the range rises");
  entries.restart();
  CHECK(rise_to(0, 1).empty());
}

TEST_CASE("Undersides are dimmed in layers of the print only") {
  CHECK(contract_broken_by([] {
          UndersideDimming dimming({}, nullptr, {}, {.layers = {layer(0)}, .resin = {.curve = kResinCurve}});
          (void)dimming.dimmed(1);
        }) == "the layer is one of the print's");
}

TEST_CASE("The masks of a print require a height for each layer, or none") {
  const DisplayGeometry display{Pixels{4}, Pixels{4}, Micrometers{50}};
  ContourEngine engine({}, {.display = display});
  const std::array layers{layer(0), layer(1)};
  const std::array heights{kThickness / 2};
  PrintLight light{.layers = layers, .cure = {.curve = kResinCurve}};
  CHECK(contract_broken_by([&] { PrintCure(engine, display, light, {}); }).empty());
  light.mask_heights = heights;
  CHECK(contract_broken_by([&] { PrintCure(engine, display, light, {}); }) ==
        "each layer has a height, or none");
}
