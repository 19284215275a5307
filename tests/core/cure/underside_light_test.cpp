// Tests the light of a solid's lowest layers by the dose that the underside then has.
#include "core/cure/underside_light.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "tests/catch.hpp"

namespace {

constexpr double kDepthUm = 150, kLayerUm = 50, kOverUm = 50;

// Returns the doses that layers give to the underside at the first layer's bottom, over Ec.
std::vector<double> doses_of(int layers) {
  std::vector<double> doses;
  for (int layer = 1; layer <= layers; ++layer)
    doses.push_back(std::exp((kLayerUm + kOverUm - layer * kLayerUm) / kDepthUm));
  return doses;
}

// Follows the dose at the underside through the print.
double dose_with(const UndersideLight& light, const std::vector<double>& doses, const PeelLoss& loss) {
  double dose = 0, greatest = 0;
  for (std::size_t layer = 0; layer < doses.size(); ++layer) {
    const double share = layer < light.dark ? 0 : layer == light.dark ? light.next_share : 1;
    dose = std::max(dose * loss.kept - loss.lost, 0.0) + share * doses[layer];
    greatest = std::max(greatest, dose);
  }
  return greatest;
}

}  // namespace

TEST_CASE("A thick overhang without loss gets no light in four layers, and 19 percent in the fifth") {
  const UndersideLight light = underside_light(doses_of(60), {}, 20);
  CHECK(light.dark == 4);
  CHECK(light.next_share == Approx(0.19).margin(0.005));
}

TEST_CASE("The underside's dose is Ec, whatever is lost at a peel") {
  const std::vector<double> doses = doses_of(60);
  for (const double kept : {1.0, 0.95, 0.9, 0.75, 0.5, 0.0})
    for (const double lost : {0.0, 0.05, 0.5}) {
      const PeelLoss loss{kept, lost};
      const UndersideLight light = underside_light(doses, loss, 20);
      CAPTURE(kept, lost, light.dark, light.next_share);
      CHECK(dose_with(light, doses, loss) == Approx(1).margin(1e-3));
    }
}

TEST_CASE("Doses of any kind are brought to Ec, or stay below it with all their light") {
  std::mt19937 random(30);
  std::uniform_real_distribution<double> dose(0, 0.8), kept(0, 1);
  for (int run = 0; run < 500; ++run) {
    std::vector<double> doses(1 + static_cast<std::size_t>(run % 30));
    std::ranges::generate(doses, [&] { return dose(random); });
    const PeelLoss loss{kept(random), run % 3 == 0 ? 0.1 : 0};
    const UndersideLight light = underside_light(doses, loss, doses.size() - 1);
    CAPTURE(run, light.dark, light.next_share);
    if (dose_with({}, doses, loss) <= 1) {
      CHECK(light == UndersideLight{});
    } else {
      // The last layer always keeps its light, 0.8 at most.
      CHECK(dose_with(light, doses, loss) == Approx(1).margin(1e-3));
    }
  }
}

TEST_CASE("No more layers are dimmed than may be") {
  const UndersideLight light = underside_light(doses_of(60), {}, 2);
  CHECK(light == UndersideLight{.dark = 2, .next_share = 1});
  CHECK(underside_light(doses_of(60), {}, 0) == UndersideLight{});
}
