// Tests the fit of the peel memory with an owner who prints the bridges and measures them with an error.
#include "core/calibration/peel_memory_fit.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/calibration/calibration_models.hpp"
#include "core/calibration/joined_blocks.hpp"
#include "core/cure/cured_part.hpp"
#include "core/layers/layers.hpp"
#include "tests/catch.hpp"
#include "tests/core/engine_fixture.hpp"

namespace {

using contourd::testing::plate_model;

constexpr Nanometers kBridgeLayer{50'000};
constexpr DisplayGeometry kBridgeDisplay{Pixels{800}, Pixels{400}, Micrometers{50.0}};
constexpr double kCaliperUm = 10;  // standard deviation of a measurement

CureSettings resin_of(double memory, double depth_um = 150, double oxygen = 0, double dead_zone_um = 0) {
  return {.curve = {Micrometers{depth_um}, MillijoulesPerCm2{8}},
          .peel_memory = memory,
          .oxygen_dose = MillijoulesPerCm2{oxygen},
          .dead_zone = Micrometers{dead_zone_um}};
}

// A print at a layer height, each layer cured 50 um beyond it.
BridgePrint print_with(const CureSettings& resin, Nanometers layer = kBridgeLayer) {
  return {resin, layer, resin.curve.dose_for(Micrometers{in_mm(layer) * 1000 + 50})};
}

// Prints the bridges by their own masks and returns their thicknesses.
std::vector<BridgeThickness> printed_bridges(const BridgePrint& print) {
  const Millimeters layer_mm = to_millimeters(print.layer_height);
  auto model = std::make_shared<const HeightIndex>(bridge_model(layer_mm, Millimeters{4}));
  const auto count = static_cast<int>(std::lround(model->bounds().size_z() / layer_mm.count()));
  const PixelMap map = PixelMap::true_scale(kBridgeDisplay, model->bounds().center());
  std::vector<PlateModel> models;
  models.push_back({{model}, {map}});
  ContourEngine engine(std::move(models), {.display = kBridgeDisplay});
  std::vector<CuredLayers> cured(kBridgeLayers.size(), CuredLayers(print.resin, 1));
  std::vector<double> lowest_mm(kBridgeLayers.size());
  std::vector<bool> has_ended(kBridgeLayers.size());
  double top_mm = 0;
  for (int number = count; number-- > 0;) {
    const LayerDose layer{print.layer_height * (number + 1), print.layer_height, print.dose};
    const Mask& mask = engine.mask_at(print.layer_height * number + print.layer_height / 2);
    for (std::size_t bridge = 0; bridge < kBridgeLayers.size(); ++bridge) {
      const PixelPoint pixel = map.to_pixels(bridge_middle(bridge));
      const std::array light{static_cast<float>(mask.row(
                                 static_cast<std::int32_t>(pixel.y))[static_cast<std::size_t>(pixel.x)]) /
                             255};
      const double solid =
          cured[bridge].solid_thickness(layer, cured[bridge].add_layer(layer, light).front()).count();
      if (number + 1 == count) top_mm = cured[bridge].solid_top(layer).count();
      if (solid == 0 && light[0] == 0) has_ended[bridge] = true;
      if (solid > 0 && !has_ended[bridge]) lowest_mm[bridge] = cured[bridge].solid_top(layer).count() - solid;
    }
  }
  std::vector<BridgeThickness> bridges;
  for (std::size_t bridge = 0; bridge < kBridgeLayers.size(); ++bridge)
    bridges.push_back({kBridgeLayers[bridge], Micrometers{(top_mm - lowest_mm[bridge]) * 1000}});
  return bridges;
}

std::vector<BridgeThickness> measured(const std::vector<BridgeThickness>& bridges, int times,
                                      std::mt19937& random) {
  std::normal_distribution<double> error(0, kCaliperUm);
  std::vector<BridgeThickness> values;
  for (int time = 0; time < times; ++time)
    for (const BridgeThickness& bridge : bridges)
      values.push_back({bridge.layers, bridge.thickness + Micrometers{error(random)}});
  return values;
}

std::string memory_refusal_of_curve(const BridgePrint& print, const std::vector<BridgeThickness>& values,
                                    const CurveUncertainty& curve) {
  try {
    (void)fit_peel_memory(print, values, curve);
  } catch (const CalibrationRefused& refused) {
    return refused.what();
  }
  return "";
}
std::string memory_refusal(const BridgePrint& print, const std::vector<BridgeThickness>& values) {
  return memory_refusal_of_curve(print, values, {});
}

}  // namespace

TEST_CASE("The bridges' own masks cure to the thickness that the fit expects") {
  for (const double memory : {1.0, 0.9, 0.5, 0.0})
    for (const CureSettings& resin : {resin_of(memory), resin_of(memory, 100, 1.5, 12)}) {
      const BridgePrint print = print_with(resin);
      for (const auto& [layers, thickness] : printed_bridges(print)) {
        CAPTURE(memory, layers);
        // A halving of the search by CuredLayers is 50 um / 65536.
        CHECK(bridge_thickness(print, memory, layers).count() == Approx(thickness.count()).margin(0.01));
      }
    }
}

TEST_CASE("A bridge is as thick as its layers and the print-through of their number") {
  constexpr std::array print_through_um{50, 131, 193, 228, 238};  // Dp 150, 50 um layers, 50 um overcure
  const BridgePrint print = print_with(resin_of(1));
  for (std::size_t bridge = 0; bridge < kBridgeLayers.size(); ++bridge)
    CHECK(bridge_thickness(print, 1, kBridgeLayers[bridge]).count() ==
          Approx(50 * kBridgeLayers[bridge] + print_through_um[bridge]).margin(0.6));
}

TEST_CASE("The memory of exact bridges is found exactly") {
  for (const Nanometers layer : {Nanometers{25'000}, Nanometers{50'000}, Nanometers{100'000}})
    for (const double memory : {1.0, 0.97, 0.9, 0.75, 0.5}) {
      const BridgePrint print = print_with(resin_of(memory), layer);
      const PeelMemoryFit fit = fit_peel_memory(print, printed_bridges(print));
      CAPTURE(memory, layer.count());
      CHECK(fit.memory.value == Approx(memory).margin(1e-3));
      CHECK(fit.scatter_um < 0.1);
    }
}

TEST_CASE("A memory of all and of nothing is stated as such, and as uncertain as the readings are rounded") {
  for (const double memory : {1.0, 0.0}) {
    const BridgePrint print = print_with(resin_of(memory));
    std::vector<BridgeThickness> bridges;
    for (const int layers : kBridgeLayers)
      bridges.push_back({layers, bridge_thickness(print, memory, layers)});
    CHECK(fit_peel_memory(print, bridges).memory.value == memory);
    const PeelMemoryFit rounded = fit_peel_memory(print, bridges, {}, Micrometers{1 / std::sqrt(12)});
    CAPTURE(memory);
    CHECK(rounded.memory.uncertainty > 1e-5);
    CHECK(rounded.scatter_um == Approx(1 / std::sqrt(12)));
  }
}

TEST_CASE("An owner with calipers finds the memory within 0.02, and its uncertainty") {
  struct Row {
    double memory;
    int times;  // that each bridge is measured, on several prints
  };
  for (const auto& [memory, times] : {Row{0.95, 6}, Row{0.9, 9}, Row{0.75, 16}}) {
    const BridgePrint print = print_with(resin_of(memory));
    const std::vector<BridgeThickness> bridges = printed_bridges(print);
    int within_two = 0;
    constexpr int kOwners = 60;
    for (unsigned seed = 0; seed < kOwners; ++seed) {
      std::mt19937 random(seed);
      const PeelMemoryFit fit = fit_peel_memory(print, measured(bridges, times, random));
      CAPTURE(memory, seed, fit.memory.value, fit.memory.uncertainty);
      CHECK(fit.memory.value == Approx(memory).margin(0.02));
      within_two += std::abs(fit.memory.value - memory) <= 2 * fit.memory.uncertainty ? 1 : 0;
    }
    CAPTURE(memory, within_two);
    CHECK(within_two >= 51);  // of 60; 57 are expected, and fewer than 51 once in 200
  }
}

namespace {

// Prints a slab of 3 mm on two posts, with the undersides dimmed for `assumed`, in a resin that is `real`.
SurfaceDistances undersides_of(const CureSettings& assumed, const CureSettings& real,
                               MillijoulesPerCm2 dose) {
  const std::array slab{Block{{0, 0, 0}, {1, 4, 3}}, Block{{5, 0, 0}, {6, 4, 3}},
                        Block{{0, 0, 3}, {6, 4, 6}}};
  UndersideCure dimming{.layers = {}, .resin = assumed, .mask_budget = std::chrono::minutes{1}};
  for (int layer = 1; layer <= 120; ++layer)
    dimming.layers.push_back({kBridgeLayer * layer, kBridgeLayer, dose});
  const EngineSettings settings{.display = {Pixels{160}, Pixels{120}, Micrometers{50}}};
  std::vector<PlateModel> models;
  models.push_back(plate_model(joined(slab), {}, settings.display, {3, 2}));
  ContourEngine engine(std::move(models), settings);
  UndersideDimming undersides(engine.models(), nullptr, settings, dimming);
  return cure_part(engine, settings.display,
                   {.layers = dimming.layers, .cure = real, .undersides = &undersides}, nullptr)
      .figures.undersides;
}

}  // namespace

TEST_CASE("Bridges that were measured three times put the next print's undersides within 15 um") {
  for (const double memory : {0.95, 0.9, 0.75, 0.5, 0.1}) {
    const BridgePrint print = print_with(resin_of(memory));
    const std::vector<BridgeThickness> bridges = printed_bridges(print);
    for (unsigned seed = 0; seed < 6; ++seed) {
      std::mt19937 random(seed);
      const PeelMemoryFit fit = fit_peel_memory(print, measured(bridges, 3, random));
      CAPTURE(memory, seed, fit.memory.value, fit.memory.uncertainty);
      CHECK(fit.underside_um < 15);
      const SurfaceDistances next = undersides_of(resin_of(fit.memory.value), resin_of(memory), print.dose);
      CHECK(next.missing == 0);
      CHECK(next.p95_um < 15);
    }
  }
}

TEST_CASE("A memory that was fitted with a curve that is somewhat wrong makes up for it at undersides") {
  for (const double memory : {0.9, 0.7})
    for (const double assumed_um : {144.0, 156.0}) {  // 4 % off
      const CureSettings real = resin_of(memory);
      BridgePrint print = print_with(real);
      const std::vector<BridgeThickness> bridges = printed_bridges(print);
      print.resin.curve.penetration_depth = Micrometers{assumed_um};
      const PeelMemoryFit fit = fit_peel_memory(print, bridges);
      CAPTURE(memory, assumed_um, fit.memory.value, fit.scatter_um);
      CureSettings assumed = print.resin;
      assumed.peel_memory = fit.memory.value;
      CHECK(undersides_of(assumed, real, print.dose).p95_um < 15);
    }
}

TEST_CASE("The memory's uncertainty contains that of the curve with which it is fitted") {
  // Owners whose curves are wrong by draws from the stated uncertainties, with the stated correlation.
  constexpr double kDepthUm = 3.7, kDose = 0.45, kCorrelation = 0.9;
  const CurveUncertainty curve{Micrometers{kDepthUm}, MillijoulesPerCm2{kDose}, kCorrelation};
  const CureSettings real = resin_of(0.85);
  const BridgePrint print = print_with(real);
  const std::vector<BridgeThickness> bridges = printed_bridges(print);
  constexpr int kOwners = 60;
  double squares = 0, stated = 0, by_scatter = 0;
  for (unsigned seed = 0; seed < kOwners; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0, 1);
    const double first = error(random), second = error(random);
    BridgePrint assumed = print;
    assumed.resin.curve.penetration_depth += Micrometers{kDepthUm * first};
    assumed.resin.curve.critical_dose += MillijoulesPerCm2{
        kDose * (kCorrelation * first + std::sqrt(1 - kCorrelation * kCorrelation) * second)};
    const PeelMemoryFit fit = fit_peel_memory(assumed, measured(bridges, 6, random), curve);
    squares += std::pow(fit.memory.value - 0.85, 2) / kOwners;
    stated += fit.memory.uncertainty / kOwners;
    by_scatter += fit.shares.scatter / kOwners;
  }
  CAPTURE(std::sqrt(squares), stated, by_scatter);
  // The standard deviation of 60 draws is known within a tenth.
  CHECK(stated == Approx(std::sqrt(squares)).epsilon(0.3));
  CHECK(stated > 1.2 * by_scatter);
}

TEST_CASE("The shares of the memory's uncertainty add up as their errors do") {
  const BridgePrint print = print_with(resin_of(0.9));
  std::mt19937 random(1);
  const std::vector<BridgeThickness> bridges = measured(printed_bridges(print), 6, random);
  const PeelMemoryFit alone = fit_peel_memory(print, bridges);
  CHECK(alone.memory.uncertainty == Approx(alone.shares.scatter));
  CHECK(alone.shares.penetration_depth == 0);
  const auto with = [&](double correlation) {
    return fit_peel_memory(print, bridges, {Micrometers{4}, MillijoulesPerCm2{0.4}, correlation});
  };
  const auto [memory, shares, scatter, underside] = with(0);
  CHECK(memory.value == alone.memory.value);
  CHECK(memory.uncertainty ==
        Approx(std::hypot(shares.scatter, shares.penetration_depth, shares.critical_dose)));
  // A greater penetration depth explains thicker bridges with less memory, a greater critical dose with more.
  CHECK(shares.penetration_depth < -0.001);
  CHECK(shares.critical_dose > 0.001);
  CHECK(with(1).memory.uncertainty ==
        Approx(std::hypot(shares.scatter, shares.penetration_depth + shares.critical_dose)));
  CHECK(memory_refusal_of_curve(print, bridges, {Micrometers{40}, MillijoulesPerCm2{0.4}, 0})
            .starts_with("the resin's penetration_depth_um of 150 is uncertain by 40, more than a quarter"));
  CHECK(memory_refusal_of_curve(print, bridges, {Micrometers{4}, MillijoulesPerCm2{2.1}, 0})
            .starts_with("the resin's critical_energy_mj_cm2 of 8 is uncertain by 2.1"));
}

TEST_CASE("Bridges that do not determine the memory are refused with their figures") {
  const BridgePrint print = print_with(resin_of(0.9));
  const std::vector<BridgeThickness> good = printed_bridges(print);
  REQUIRE(memory_refusal(print, good).empty());
  CHECK(lacking(memory_refusal(print, {}), {"0 thicknesses"}).empty());
  CHECK(lacking(memory_refusal(print, {good[0], good[0], good[0], good[0], good[1], good[2], good[3]}),
                {"3 thicknesses of bridges of two layers or more"})
            .empty());
  std::vector<BridgeThickness> torn = good;
  torn[2].thickness = Micrometers{0};
  CHECK(lacking(memory_refusal(print, torn), {"a bridge of 4 layers that is 0 um thick"}).empty());
  torn[2].thickness = Micrometers{1e300};
  CHECK(lacking(memory_refusal(print, torn),
                {"a bridge of 4 layers that is 1e+300 um thick", "at most 100000 um"})
            .empty());
  torn[2] = {101, Micrometers{100}};
  CHECK(lacking(memory_refusal(print, torn), {"a bridge of 101 layers"}).empty());
  torn[2] = {4, Micrometers{std::nan("")}};
  CHECK(lacking(memory_refusal(print, torn), {"a bridge of 4 layers that is nan um thick"}).empty());
  std::vector<BridgeThickness> swapped = good;
  std::swap(swapped[2].thickness, swapped[3].thickness);
  CHECK(lacking(memory_refusal(print, swapped), {"um about those of the best memory", "more than 40 um"})
            .empty());
  std::vector<BridgeThickness> rough = good;
  for (std::size_t i = 0; i < rough.size(); ++i)
    rough[i].thickness += Micrometers{i % 2 == 0 ? 35.0 : -35.0};
  CHECK(lacking(memory_refusal(print, rough), {"is uncertain by", "more than 15 um"}).empty());
}

TEST_CASE("Bridges beyond those of any memory are refused: the working curve is wrong") {
  for (const double memory : {1.0, 0.0}) {
    const BridgePrint print = print_with(resin_of(memory));
    std::vector<BridgeThickness> bridges = printed_bridges(print);
    CHECK(memory_refusal(print, bridges).empty());
    for (BridgeThickness& bridge : bridges)
      bridge.thickness += Micrometers{memory > 0.5 ? 25.0 : -25.0};
    CAPTURE(memory);
    CHECK(lacking(memory_refusal(print, bridges),
                  {memory > 0.5 ? "the bridges are 25 um thicker" : "the bridges are 25 um thinner"})
              .empty());
  }
}
