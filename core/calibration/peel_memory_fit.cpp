#include "core/calibration/peel_memory_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <vector>

#include "core/calibration/refuse.hpp"
#include "core/contract/expects.hpp"

namespace contourd {
namespace {

constexpr std::ptrdiff_t kFewestBridges = 4;
constexpr double kMostBridgeScatterUm = 40;
constexpr double kMostUnsureUndersideUm = 15;  // of an underside
constexpr int kThickPart = 16;                 // layers

// The squares of the thicknesses' differences, as a function of the memory.
class BridgeSquares {
 public:
  BridgeSquares(const BridgePrint& print, std::span<const BridgeThickness> measured)
      : print_(print), measured_(measured) {}

  [[nodiscard]] double at(double memory) const {
    double squares = 0;
    for (const double difference : differences(memory))
      squares += difference * difference;
    return squares;
  }
  // Returns by how many um each bridge is thicker than with this memory.
  [[nodiscard]] std::vector<double> differences(double memory) const {
    std::map<int, double> expected_um;
    std::vector<double> differences;
    for (const auto& [layers, thickness] : measured_) {
      const auto [expected, is_new] = expected_um.try_emplace(layers);
      if (is_new) expected->second = bridge_thickness(print_, memory, layers).count();
      differences.push_back(thickness.count() - expected->second);
    }
    return differences;
  }

  // Returns the memory with the least squares.
  [[nodiscard]] double best() const {
    constexpr int kSteps = 50;
    int best = 0;
    double least = at(0);
    for (int step = 1; step <= kSteps; ++step) {
      const double squares = at(1.0 * step / kSteps);
      if (squares < least) {
        least = squares;
        best = step;
      }
    }
    double low = std::max(0.0, (best - 1.0) / kSteps), high = std::min(1.0, (best + 1.0) / kSteps);
    while (high - low > kExact) {
      const double third = (high - low) / 3;
      const bool is_lower = at(low + third) <= at(high - third);
      (is_lower ? high : low) += is_lower ? -third : third;
    }
    return (low + high) / 2;
  }

  // Returns the memory between these two at which the squares reach a limit; `beyond` if they do not.
  [[nodiscard]] double reaches(double limit, double best, double beyond) const {
    if (at(beyond) <= limit) return beyond;
    while (std::abs(beyond - best) > kExact) {
      const double middle = (best + beyond) / 2;
      (at(middle) <= limit ? best : beyond) = middle;
    }
    return best;
  }

 private:
  static constexpr double kExact = 1e-5;

  const BridgePrint& print_;
  std::span<const BridgeThickness> measured_;
};

void check_bridges(std::span<const BridgeThickness> measured) {
  for (const auto& [layers, thickness] : measured) {
    if (layers < 1 || layers > kMostBridgeLayers || !(thickness.count() > 0))
      refuse(
          "a bridge of %d layers that is %.4g um thick: a bridge has 1 to %d layers and a thickness; leave "
          "out bridges that are torn",
          layers, thickness.count(), kMostBridgeLayers);
  }
  const auto several = std::ranges::count_if(measured, [](const auto& bridge) { return bridge.layers > 1; });
  if (several < kFewestBridges)
    refuse(
        "%td thicknesses of bridges of two layers or more do not determine the memory: measure at least "
        "%td, better each bridge three times",
        several, kFewestBridges);
}

// Refuses thicknesses that no memory explains, because they lie beyond those of the best one, 0 or 1.
void check_within(const std::vector<double>& differences, double memory) {
  if (memory > 0.001 && memory < 0.999) return;
  const auto count = static_cast<double>(differences.size());
  double mean = 0, squares = 0;
  for (const double difference : differences)
    mean += difference / count;
  for (const double difference : differences)
    squares += (difference - mean) * (difference - mean);
  const double unsure = std::sqrt(squares / (count - 1) / count);
  const bool is_beyond = memory < 0.5 ? mean < 0 : mean > 0;
  if (is_beyond && std::abs(mean) > std::max(3 * unsure, kMostUnsureUndersideUm))
    refuse(
        "the bridges are %.3g um %s on average than with a memory of %.0f: check the working curve, with "
        "the resin as warm as in this print, and the resin's exposure",
        std::abs(mean), mean < 0 ? "thinner" : "thicker", std::round(memory));
}

}  // namespace

Micrometers bridge_thickness(const BridgePrint& print, double memory, int layers) {
  expects(print.layer_height > Nanometers{}, "layers have a height");
  expects(layers >= 1 && layers <= kMostBridgeLayers, "a bridge has some layers");
  constexpr int kMostDark = 10'000;
  CureSettings resin = print.resin;
  resin.peel_memory = memory;
  CuredLayers cured(resin, 1);
  Millimeters highest{}, lowest{};
  for (int below = 0; below < layers + kMostDark; ++below) {
    const LayerDose layer{print.layer_height * (layers + kMostDark - below), print.layer_height, print.dose};
    const std::array light{below < layers ? 1.0F : 0.0F};
    const Millimeters solid = cured.solid_thickness(layer, cured.add_layer(layer, light).front());
    if (below == 0) highest = lowest = cured.solid_top(layer);
    if (solid > Millimeters{}) {
      lowest = cured.solid_top(layer) - solid;
    } else if (below >= layers) {
      break;
    }
  }
  return Micrometers{(highest - lowest).count() * 1000};
}

PeelMemoryFit fit_peel_memory(const BridgePrint& print, std::span<const BridgeThickness> measured) {
  expects(print.layer_height > Nanometers{}, "bridges have layers");
  check_bridges(measured);
  const BridgeSquares squares(print, measured);
  const double best = squares.best(), least = squares.at(best);
  const double variance = least / static_cast<double>(measured.size() - 1);
  const double scatter = std::sqrt(variance);
  check_within(squares.differences(best), best);
  if (!(scatter <= kMostBridgeScatterUm))
    refuse(
        "the thicknesses scatter by %.3g um about those of the best memory, %.3g: more than %g um; check "
        "which thickness belongs to which bridge, and the working curve",
        scatter, best, kMostBridgeScatterUm);
  // One standard deviation to either side, also where the memory hardly matters.
  const double low = squares.reaches(least + variance, best, 0);
  const double high = squares.reaches(least + variance, best, 1);
  const double underside =
      (bridge_thickness(print, high, kThickPart).count() - bridge_thickness(print, low, kThickPart).count()) /
      2;
  if (!(underside <= kMostUnsureUndersideUm))
    refuse(
        "the memory of %.3g is uncertain by %.3g, which is %.3g um at an underside, more than %g um: measure "
        "each bridge several times, or print the bridges again",
        best, (high - low) / 2, underside, kMostUnsureUndersideUm);
  return {.memory = {best, (high - low) / 2}, .scatter_um = scatter, .underside_um = underside};
}

}  // namespace contourd
