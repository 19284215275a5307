// Tests the dose of layers against published and computed print-through, and against the light on a fine
// grid.
#include "core/cure/cured_layers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/cure/underside_light.hpp"
#include "tests/catch.hpp"
#include "tests/core/cure/published_resins.hpp"

namespace {

constexpr double kCritical = 8;  // mJ/cm2

struct Print {
  double depth_um, layer_um, overcure_um;
};

CureSettings settings(const Print& print, double memory = 1, double oxygen = 0, double dead_zone_um = 0) {
  return {.curve = {Micrometers{print.depth_um}, MillijoulesPerCm2{kCritical}},
          .peel_memory = memory,
          .oxygen_dose = MillijoulesPerCm2{oxygen},
          .dead_zone = Micrometers{dead_zone_um}};
}

LayerDose layer_of(const Print& print, int layer, double share = 1) {
  const Nanometers thickness{std::llround(print.layer_um * 1000)};
  const MillijoulesPerCm2 dose =
      settings(print).curve.dose_for(Micrometers{print.layer_um + print.overcure_um});
  return {thickness * (layer + 1), thickness, dose * share};
}

// Returns how far below its drawn place the underside of an overhang solidifies, in um. The overhang has
// `layers` layers over enough dark ones.
double print_through_um(const Print& print, double memory, int layers) {
  constexpr int kDark = 40;
  CuredLayers cured(settings(print, memory), 1);
  double lowest_mm = 1e9;
  for (int layer = kDark + layers - 1; layer >= 0; --layer) {
    const std::array light{layer >= kDark ? 1.0F : 0.0F};
    const LayerDose of = layer_of(print, layer);
    const float dose = cured.add_layer(of, light).front();
    const double solid = cured.solid_thickness(of, dose).count();
    if (solid > 0) lowest_mm = cured.solid_top(of).count() - solid;
  }
  return (kDark * print.layer_um / 1000 - lowest_mm) * 1000;
}

}  // namespace

TEST_CASE("Thick overhangs print through as far as the formula and the memory tell") {
  // By the share of its dose that liquid resin keeps at a peel: 1, 0.95, 0.9, 0.75, 0.5, 0.
  constexpr std::array memories{1.0, 0.95, 0.9, 0.75, 0.5, 0.0};
  struct Row {
    Print print;
    std::array<double, 6> um;
  };
  for (const Row& row :
       {Row{{150, 50, 50}, {239, 192, 168, 122, 79, 50}}, Row{{100, 50, 50}, {143, 120, 107, 83, 60, 50}},
        Row{{200, 50, 50}, {352, 275, 237, 166, 99, 50}}, Row{{150, 25, 50}, {331, 256, 221, 157, 99, 50}}}) {
    for (std::size_t i = 0; i < memories.size(); ++i) {
      CAPTURE(row.print.depth_um, row.print.layer_um, memories[i]);
      CHECK(print_through_um(row.print, memories[i], 60) ==
            Approx(row.um[i]).margin(0.6));  // rounded to 1 um
    }
  }
}

TEST_CASE("Overhangs of few layers print through less") {
  constexpr std::array layers{1, 2, 4, 8, 16};
  struct Row {
    Print print;
    std::array<double, 5> um;
  };
  for (const Row& row :
       {Row{{150, 50, 50}, {50, 131, 193, 228, 238}}, Row{{100, 50, 50}, {50, 97, 129, 141, 143}},
        Row{{200, 50, 50}, {50, 165, 260, 323, 348}}, Row{{150, 25, 50}, {50, 142, 223, 285, 320}}}) {
    for (std::size_t i = 0; i < layers.size(); ++i) {
      CAPTURE(row.print.depth_um, row.print.layer_um, layers[i]);
      CHECK(print_through_um(row.print, 1, layers[i]) == Approx(row.um[i]).margin(0.6));
    }
  }
}

namespace {

// Returns how far below its drawn place an overhang of 200 layers of 50 um begins, in um. `share` returns the
// light of one of its layers, from 0.
template <typename Share>
double underside_um(const CureSettings& of, MillijoulesPerCm2 dose, Share share) {
  constexpr Nanometers kLayer{50'000};
  constexpr int kDark = 60, kLit = 200;
  CuredLayers cured(of, 1);
  double lowest_mm = 1e9;
  for (int layer = kDark + kLit - 1; layer >= 0; --layer) {
    const std::array light{layer >= kDark ? static_cast<float>(share(layer - kDark)) : 0.0F};
    const LayerDose exposed{kLayer * (layer + 1), kLayer, dose};
    const double solid = cured.solid_thickness(exposed, cured.add_layer(exposed, light).front()).count();
    if (solid > 0) lowest_mm = cured.solid_top(exposed).count() - solid;
  }
  return 1000 * (kDark * 0.05 - lowest_mm);
}

double plain_underside_um(const WorkingCurve& curve, MillijoulesPerCm2 dose) {
  return underside_um({.curve = curve}, dose, [](int) { return 1.0; });
}

constexpr WorkingCurve kFactsCurve{Micrometers{150}, MillijoulesPerCm2{kCritical}};

}  // namespace

TEST_CASE("Undersides move by 21 um with Dp 5 % larger, by -18 with Ec 13 % larger, by 30 with 5 C more") {
  const MillijoulesPerCm2 dose = kFactsCurve.dose_for(Micrometers{100});
  const auto moved = [&](const WorkingCurve& curve) {
    return plain_underside_um(curve, dose) - plain_underside_um(kFactsCurve, dose);
  };
  CHECK(moved({Micrometers{157.5}, kFactsCurve.critical_dose}) == Approx(21).margin(0.6));  // rounded to 1 um
  CHECK(moved({kFactsCurve.penetration_depth, kFactsCurve.critical_dose * 1.13}) == Approx(-18).margin(0.6));
  CHECK(moved(at_temperature(kFactsCurve, {}, 30)) == Approx(30).margin(0.6));
}

TEST_CASE("Overhangs of published resins print through by Dp ln(E q / (Ec (1 - q)))") {
  for (const PublishedResin& resin : kPublishedResins) {
    CAPTURE(resin.name, resin.depth_um, resin.dose);
    const WorkingCurve curve{Micrometers{resin.depth_um}, MillijoulesPerCm2{resin.dose}};
    const double beneath = std::exp(-50 / resin.depth_um);  // light of the layer above, q
    CHECK(plain_underside_um(curve, curve.dose_for(Micrometers{100})) ==
          Approx(100 + resin.depth_um * std::log(beneath / (1 - beneath))).margin(0.1));
  }
}

TEST_CASE("An underside that is dimmed for the wrong memory is missing as far as the literature says") {
  std::vector<double> doses;
  for (int layer = 1; layer <= 60; ++layer)
    doses.push_back(std::exp((100 - layer * 50) / 150.0));
  const UndersideLight light = underside_light(doses, {}, 20);  // for resin that keeps all its dose
  const auto share = [&light](int layer) {
    const auto number = static_cast<std::size_t>(layer);
    return number < light.dark ? 0 : number == light.dark ? light.next_share : 1;
  };
  for (const auto& [memory, missing_um] :
       {std::pair(1.0, 0.0), {0.95, 48.0}, {0.9, 73.0}, {0.75, 119.0}, {0.5, 163.0}, {0.0, 200.0}}) {
    CAPTURE(memory);
    const CureSettings of{.curve = kFactsCurve, .peel_memory = memory};
    CHECK(-underside_um(of, kFactsCurve.dose_for(Micrometers{100}), share) == Approx(missing_um).margin(1));
  }
}

namespace {

struct Exposure {
  LayerDose layer;
  float light;
};

// Returns whether resin at a height ever solidifies, by following its dose through the print in the order of
// time. Shares no code with CuredLayers.
bool solidifies(const std::vector<Exposure>& print, const CureSettings& of, double z_um) {
  double dose = 0;
  bool peeled = true;  // before the exposure
  for (const Exposure& exposure : print) {
    const double kept = peeled ? of.peel_memory : 1, lost = peeled ? of.oxygen_dose.count() : 0;
    peeled = exposure.layer.peeled;
    const double film_um = static_cast<double>(exposure.layer.top.count()) / 1000;
    const double above_um = film_um - z_um;
    if (above_um < of.dead_zone.count()) continue;  // beyond the film, or kept liquid
    dose = std::max(0.0, dose * kept - lost) + static_cast<double>(exposure.light) *
                                                   exposure.layer.dose.count() *
                                                   std::exp(-above_um / of.curve.penetration_depth.count());
    if (dose >= of.curve.critical_dose.count()) return true;
  }
  return false;
}

std::vector<Exposure> random_print(std::mt19937& random) {
  std::uniform_int_distribution thickness(20, 100), run(1, 12), choice(0, 3);
  std::uniform_real_distribution<float> grey(0, 1);
  std::uniform_real_distribution overcure(5.0, 120.0);
  std::vector<Exposure> print;
  Nanometers top{};
  while (print.size() < 80) {
    const int kind = choice(random);
    for (int layers = run(random); layers > 0; --layers) {
      const Nanometers thick{thickness(random) * 1000};
      top += thick;
      const double dose = kCritical * std::exp((in_mm(thick) * 1000 + overcure(random)) / 120);
      print.push_back({{top, thick, MillijoulesPerCm2{dose}},
                       kind == 0   ? 0.0F
                       : kind == 1 ? grey(random)
                                   : 1.0F});
    }
  }
  return print;
}

// Replaces each layer of some runs by a rise: thin layers without a peel, with the layer's light in all.
std::vector<Exposure> with_rises(const std::vector<Exposure>& print, std::mt19937& random) {
  std::uniform_int_distribution choice(0, 5);
  std::vector<Exposure> risen;
  bool rises = false;
  for (const Exposure& exposure : print) {
    if (choice(random) == 0) rises = !rises;
    if (!rises) {
      risen.push_back(exposure);
      continue;
    }
    constexpr int kParts = 10;
    for (int part = 1; part <= kParts; ++part) {
      Exposure thin = exposure;
      thin.layer.top -= exposure.layer.thickness / kParts * (kParts - part);
      thin.layer.thickness = exposure.layer.thickness / kParts;
      thin.layer.dose = exposure.layer.dose / kParts;
      thin.layer.peeled = part == kParts && choice(random) == 0;
      risen.push_back(thin);
    }
  }
  return risen;
}

}  // namespace

TEST_CASE("The solid of random prints equals that of resin followed through time on a fine grid") {
  std::mt19937 random(7);
  for (const double memory : {1.0, 0.97, 0.9, 0.6, 0.0}) {
    for (const double oxygen : {0.0, 1.5}) {
      for (const auto& [dead_zone_um, rises] :
           {std::pair{0.0, false}, {12.0, false}, {0.0, true}, {12.0, true}}) {
        std::vector<Exposure> print = random_print(random);
        if (rises) print = with_rises(print, random);
        const CureSettings of = settings({120, 50, 50}, memory, oxygen, dead_zone_um);
        CuredLayers cured(of, 1);
        for (auto exposure = print.rbegin(); exposure != print.rend(); ++exposure) {
          const std::array light{exposure->light};
          const float dose = cured.add_layer(exposure->layer, light).front();
          const double top_um = cured.solid_top(exposure->layer).count() * 1000;
          const double solid_um = cured.solid_thickness(exposure->layer, dose).count() * 1000;
          const double thick_um = in_mm(exposure->layer.thickness) * 1000;
          for (double below_um = 0.05; below_um < thick_um; below_um += 0.5) {
            // Within 0.1 um of the surface, light that is too faint to be remembered decides.
            if (std::abs(below_um - solid_um) < 0.1) continue;
            CAPTURE(memory, oxygen, rises, top_um, below_um, solid_um);
            CHECK(solidifies(print, of, top_um - below_um) == (below_um < solid_um));
          }
        }
      }
    }
  }
}

TEST_CASE("More light cures nowhere less") {
  std::mt19937 random(11);
  for (const double memory : {1.0, 0.8, 0.0}) {
    std::vector<Exposure> print = random_print(random);
    const CureSettings of = settings({120, 50, 50}, memory);
    CuredLayers cured(of, 1), more(of, 1);
    std::uniform_real_distribution<float> part(0, 1);
    for (auto exposure = print.rbegin(); exposure != print.rend(); ++exposure) {
      const std::array light{exposure->light};
      const std::array brighter{exposure->light + (1 - exposure->light) * part(random)};
      const double solid =
          cured.solid_thickness(exposure->layer, cured.add_layer(exposure->layer, light).front()).count();
      const double as_bright =
          more.solid_thickness(exposure->layer, more.add_layer(exposure->layer, brighter).front()).count();
      CHECK(as_bright >= solid - 1e-6);  // a nanometre: rounding of the sum
    }
  }
}

TEST_CASE("The topmost layer of a tall print has its own light") {
  const Print print{100, 50, 50};
  CuredLayers cured(settings(print), 2);
  constexpr int kLayer = 8000;  // 400 mm
  const std::array light{1.0F, 0.0F};
  const auto dose = cured.add_layer(layer_of(print, kLayer), light);
  CHECK(dose[0] == Approx(std::exp(1.0)));
  CHECK(dose[1] == 0);
}

namespace {

// A wedge whose top rises along a row of pixels.
struct Wedge {
  static constexpr int kPixels = 60;
  static constexpr double kPixel = 50, kLowest = 1000;  // um
  double slope;                                         // tangent

  [[nodiscard]] double top_um(double pixels) const { return kLowest + slope * kPixel * pixels; }
  // Returns the part of a pixel that the wedge covers at a height.
  [[nodiscard]] double coverage(int pixel, double height_um) const {
    return std::clamp(pixel + 1 - (height_um - kLowest) / (slope * kPixel), 0.0, 1.0);
  }
};

struct CuredTops {
  double worst_um = 0;
  int loose = 0;  // solids that are not connected to the part
};

// Cures the wedge with light that is its coverage, averaged over `heights` heights within each layer.
CuredTops cured_tops(const Wedge& wedge, int heights) {
  const Print print{150, 50, 50};
  const int layers = static_cast<int>(wedge.top_um(Wedge::kPixels) / print.layer_um) + 1;
  CuredLayers cured(settings(print), Wedge::kPixels);
  std::vector<std::vector<double>> solid(static_cast<std::size_t>(layers));  // thickness in um, by pixel
  for (int layer = layers - 1; layer >= 0; --layer) {
    std::vector<float> light(Wedge::kPixels);
    for (int pixel = 0; pixel < Wedge::kPixels; ++pixel)
      for (int i = 0; i < heights; ++i)
        light[static_cast<std::size_t>(pixel)] += static_cast<float>(
            wedge.coverage(pixel, (layer + (i + 0.5) / heights) * print.layer_um) / heights);
    const LayerDose of = layer_of(print, layer);
    for (const float dose : cured.add_layer(of, light))
      solid[static_cast<std::size_t>(layer)].push_back(cured.solid_thickness(of, dose).count() * 1000);
  }
  CuredTops tops;
  for (std::size_t pixel = 0; pixel < Wedge::kPixels; ++pixel) {
    const auto is_whole = [&](const auto& layer) { return layer[pixel] > print.layer_um - 1e-3; };
    const auto end = std::ranges::find_if_not(solid, is_whole);
    const double top_um = static_cast<double>(end - solid.begin()) * print.layer_um;
    tops.worst_um =
        std::max(tops.worst_um, std::abs(top_um - wedge.top_um(static_cast<double>(pixel) + 0.5)));
    tops.loose += static_cast<int>(
        std::count_if(end, solid.end(), [&](const auto& layer) { return layer[pixel] > 0; }));
  }
  return tops;
}

}  // namespace

TEST_CASE("Light averaged over a layer's height cures tops no better than coverage at its middle") {
  int loose = 0, loose_of_averaged = 0;
  for (const double degrees : {3, 10, 20, 30, 45}) {
    const Wedge wedge{std::tan(degrees * std::numbers::pi / 180)};
    const CuredTops middle = cured_tops(wedge, 1), averaged = cured_tops(wedge, 50);
    CAPTURE(degrees, middle.worst_um);
    CHECK(averaged.worst_um >= middle.worst_um);
    // Half a layer, and what a slope rises from a pixel's middle to its part that the mask's grey still
    // cures.
    CHECK(middle.worst_um <= 25 + 0.25 * wedge.slope * Wedge::kPixel);
    loose += middle.loose;
    loose_of_averaged += averaged.loose;
  }
  CHECK(loose_of_averaged > 2 * loose);
}
