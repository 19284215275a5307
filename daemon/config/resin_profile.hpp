// How one resin is printed: layer heights, exposures, the moves that peel a layer off. Value types;
// thread-safe.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/engine/compensation.hpp"
#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_weights.hpp"
#include "core/support/support_settings.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Exposures outside this are mistakes, not resins.
inline constexpr Duration kShortestExposure = std::chrono::milliseconds{1};
inline constexpr Duration kLongestExposure = std::chrono::seconds{120};

// Whatever the layer height is.
struct FixedExposure {
  Duration exposure{};
  Duration bottom_exposure{};
  bool operator==(const FixedExposure&) const = default;
};

// Jacobs' working curve Cd = Dp ln(E / Ec), thesis equation 2.1.
struct WorkingCurve {
  Micrometers penetration_depth;        // Dp
  double critical_energy_mj_cm2 = 0.0;  // Ec
  Micrometers overcure;                 // cure depth beyond the layer height
  Micrometers bottom_overcure;
  bool operator==(const WorkingCurve&) const = default;
};

// How far apart the bounds of a layer's light may be, and what is done when they are farther.
struct ExposureTolerance {
  Duration bounds{std::chrono::milliseconds{100}};
  enum class Policy { Warn, Interrupt };
  Policy policy = Policy::Warn;
  bool operator==(const ExposureTolerance&) const = default;
};

struct ResinProfile {
  std::string name;  // of its file, without .json
  Nanometers layer_height;
  Nanometers layer_height_min;
  Nanometers layer_height_max;
  std::variant<FixedExposure, WorkingCurve> exposure;
  Scale shrinkage_factors;  // that make good the resin's shrinkage, along the plate's axes
  int bottom_layers = 0;    // get the bottom exposure
  int fade_layers = 0;      // after those: from the bottom exposure to the normal one
  Compensation compensation;
  CarryingSupport support;
  SupportSettings supports;
  OrientationWeights orientation;  // of a model whose ticket leaves to contourd what points up
  Nanometers lift;
  MillimetersPerSecond lift_speed;
  MillimetersPerSecond retract_speed;
  Duration settle{};  // plate still, before the light
  Duration rest{};    // light off, before the lift
  ExposureTolerance tolerance;
  TicketLimits limits;
  bool operator==(const ResinProfile&) const = default;
};

// The machine that the resin is for: the figures that a profile is checked against. Those that are not known
// are not checked.
struct ResinMachine {
  std::optional<Nanometers> travel;
  std::optional<double> irradiance_mw_cm2;
  std::optional<MillimetersPerSecond> top_speed = std::nullopt;
};

// Throws ConfigError with everything that is wrong with the profile, its exposures at its own layer height
// included. What it lets tickets set keeps to the same bounds as its own settings, which are within that.
[[nodiscard]] ResinProfile load_resin_profile(const std::filesystem::path& path, const ResinMachine& machine);

// Light of layer `layer_index` (0 is the one on the plate). The fade is linear: of n fade layers, the k-th
// from 1 has gone k/(n+1) of the way. Not clamped: check with layer_height_problems() first. Throws
// std::range_error beyond a hundred years. REQUIRES: layer_index >= 0, layer_height > 0, irradiance > 0.
[[nodiscard]] Duration exposure_time(const ResinProfile& resin, Nanometers layer_height, int layer_index,
                                     double irradiance_mw_cm2);

// What speaks against printing at this layer height, a clause each: the profile's own range, an exposure
// outside kShortestExposure..kLongestExposure. Empty when nothing does. REQUIRES: layer_height > 0,
// irradiance > 0.
[[nodiscard]] std::vector<std::string> layer_height_problems(const ResinProfile& resin,
                                                             Nanometers layer_height,
                                                             double irradiance_mw_cm2);

}  // namespace contourd
