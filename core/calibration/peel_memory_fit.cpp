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
constexpr double kMostUnsureCurve = 0.25;      // error of a figure of the curve
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
    // All or nothing of the dose is a figure by itself, and not the nearest one that the search tries.
    const double found = (low + high) / 2, squares = at(found);
    if (low == 0 && at(0) <= squares) return 0;
    return high == 1 && at(1) <= squares ? 1 : found;
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
    if (layers < 1 || layers > kMostBridgeLayers ||
        !(thickness.count() > 0 && thickness.count() <= kThickestUm))
      refuse(
          "a bridge of %d layers that is %.4g um thick: a bridge has 1 to %d layers and is more than 0 "
          "and at most %g um thick; leave out bridges that are torn",
          layers, thickness.count(), kMostBridgeLayers, kThickestUm);
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

void check_curve(const WorkingCurve& curve, const CurveUncertainty& unsure) {
  const auto check = [](const char* figure, double value, double uncertainty) {
    if (!(uncertainty <= kMostUnsureCurve * value))
      refuse("the resin's %s of %.4g is uncertain by %.3g, more than a quarter: calibrate the curve again",
             figure, value, uncertainty);
  };
  check("penetration_depth_um", curve.penetration_depth.count(), unsure.penetration_depth.count());
  check("critical_energy_mj_cm2", curve.critical_dose.count(), unsure.critical_dose.count());
}

// Returns the shares of the uncertainty of a memory, `by_scatter` with that of the thicknesses' scatter. The
// light of the bridges is what it was, whatever the curve is.
MemoryShares shares_of(const BridgePrint& print, std::span<const BridgeThickness> measured,
                       const Estimate& by_scatter, const CurveUncertainty& curve) {
  // A memory of 0 or 1 changes with one sign of the error only: the larger change counts.
  const auto change = [&](Micrometers depth, MillijoulesPerCm2 dose) {
    const auto with = [&](double sign) {
      BridgePrint changed = print;
      changed.resin.curve.penetration_depth += depth * sign;
      changed.resin.curve.critical_dose += dose * sign;
      return sign * (BridgeSquares(changed, measured).best() - by_scatter.value);
    };
    if (depth.count() == 0 && dose.count() == 0) return 0.0;
    const double more = with(1), less = with(-1);
    return std::abs(more) > std::abs(less) ? more : less;
  };
  return {.scatter = by_scatter.uncertainty,
          .penetration_depth = change(curve.penetration_depth, {}),
          .critical_dose = change({}, curve.critical_dose)};
}

double total_of(const MemoryShares& shares, double correlation) {
  const double curve = shares.penetration_depth * shares.penetration_depth +
                       shares.critical_dose * shares.critical_dose +
                       2 * correlation * shares.penetration_depth * shares.critical_dose;
  return std::sqrt(shares.scatter * shares.scatter + std::max(curve, 0.0));
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

PeelMemoryFit fit_peel_memory(const BridgePrint& print, std::span<const BridgeThickness> measured,
                              const CurveUncertainty& curve, Micrometers reading) {
  expects(print.layer_height > Nanometers{}, "bridges have layers");
  check_bridges(measured);
  check_curve(print.resin.curve, curve);
  const BridgeSquares squares(print, measured);
  const double best = squares.best(), least = squares.at(best);
  const double variance =
      std::max(least / static_cast<double>(measured.size() - 1), reading.count() * reading.count());
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
  const MemoryShares shares = shares_of(print, measured, {best, (high - low) / 2}, curve);
  return {.memory = {best, total_of(shares, curve.correlation)},
          .shares = shares,
          .scatter_um = scatter,
          .underside_um = underside};
}

}  // namespace contourd
