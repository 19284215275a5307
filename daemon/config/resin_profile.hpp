// The print settings of one resin: layer heights, exposures, the moves that peel off a layer. Value types;
// thread-safe.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "core/analysis/print_analysis.hpp"
#include "core/cure/cured_layers.hpp"
#include "core/engine/compensation.hpp"
#include "core/geometry/units.hpp"
#include "core/model/placement.hpp"
#include "core/orientation/orientation_figures.hpp"
#include "core/support/support_settings.hpp"
#include "daemon/config/continuous_resin.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Exposures outside this are mistakes, not resins.
inline constexpr Duration kShortestExposure = std::chrono::milliseconds{1};
inline constexpr Duration kLongestExposure = std::chrono::seconds{120};

// Exposures that do not depend on the layer height.
struct FixedExposure {
  Duration exposure{};
  Duration bottom_exposure{};
  std::vector<ExposureStep> steps{};  // rising; instead of `exposure`, from the lowest step up
  bool operator==(const FixedExposure&) const = default;
};

// Cure depths beyond the layer height, from which the exposures of any layer follow by the resin's working
// curve.
struct CurveExposure {
  Micrometers overcure;
  Micrometers bottom_overcure;
  bool operator==(const CurveExposure&) const = default;
};

// The tolerated uncertainty of a layer's exposure time (upper minus lower bound), and the reaction if it is
// exceeded.
struct ExposureTolerance {
  Duration bounds{std::chrono::milliseconds{100}};
  enum class Policy { Warn, Interrupt };
  Policy policy = Policy::Warn;
  bool operator==(const ExposureTolerance&) const = default;
};

// The moves and waits that peel off a layer. The plate rises in two stages, slowly while the layer peels off
// and then fast, and comes down in two, fast and then slowly while it presses the resin out.
struct LayerMotion {
  Nanometers lift{};
  MillimetersPerSecond lift_speed;
  Nanometers second_lift{};  // 0: none
  MillimetersPerSecond second_lift_speed;
  MillimetersPerSecond retract_speed;
  Nanometers slow_retract{};  // the last part of the way down; 0: none
  MillimetersPerSecond slow_retract_speed;
  Duration settle{};  // wait before the light, with the plate at rest
  Duration rest{};    // wait between the end of the light and the lift

  [[nodiscard]] Nanometers whole_lift() const { return lift + second_lift; }

  // The waits of a layer, by which the print and its time left know them.
  [[nodiscard]] Duration before_light() const { return settle; }
  [[nodiscard]] Duration after_light() const { return rest; }
  bool operator==(const LayerMotion&) const = default;
};

struct ResinProfile {
  std::string name;  // the file's name without .json
  Nanometers layer_height;
  Nanometers layer_height_min;
  Nanometers layer_height_max;
  std::variant<FixedExposure, CurveExposure> exposure;  // CurveExposure only with `cure`
  std::optional<CureSettings> cure;  // if the resin's working curve is known; at the printer's irradiance
  bool curve_measured = true;        // false: the curve is computed by the resin's ingredients
  std::optional<CureIrradiance> cure_irradiance;    // of the profile's working curve, if it is known
  std::optional<CureTemperature> cure_temperature;  // of the working curve, if it is known
  bool peel_memory_measured = false;                // otherwise `cure` assumes that nothing is forgotten
  Undersides undersides = Undersides::Plain;
  Scale shrinkage_factors;  // compensate the resin's shrinkage along the plate's axes
  int bottom_layers = 0;    // layers with the bottom exposure
  int fade_layers = 0;      // the layers after them: from the bottom exposure to the normal one
  Compensation compensation;
  CarryingSupport support;
  SupportSettings supports;
  OrientationWeights orientation;  // for models whose orientation contourd chooses
  LayerMotion motion;
  std::optional<double> viscosity_mpa_s;  // lengthens the wait before the light by the area of layers
  PrintWay mode = PrintWay::Layered;
  std::optional<ContinuousResin> continuous;  // if the vat's window lets oxygen through
  ExposureTolerance tolerance;
  TicketLimits limits;
  bool operator==(const ResinProfile&) const = default;
};

// The limits of the machine that a profile is checked against. Unknown limits are not checked.
struct ResinMachine {
  std::optional<Nanometers> travel;
  std::optional<double> irradiance_mw_cm2;  // unknown: the working curve is that at its own irradiance
  std::optional<MillimetersPerSecond> top_speed = std::nullopt;
};

// Reads a profile. Throws ConfigError with all violations, including invalid exposures at its own layer
// height. The ticket_limits must respect the bounds of the profile's own settings and must include these
// settings.
[[nodiscard]] ResinProfile load_resin_profile(const std::filesystem::path& path, const ResinMachine& machine);

// Does the same with the text that is to become a profile's file.
[[nodiscard]] ResinProfile read_resin_profile(std::string_view text, const std::filesystem::path& path,
                                              const ResinMachine& machine);

// Return the number for a key of the profile: a length in mm, a speed in mm/s, a time in ms.
[[nodiscard]] double figure_of(Nanometers length);
[[nodiscard]] double figure_of(MillimetersPerSecond speed);
[[nodiscard]] double figure_of(Duration time);

// Returns the settings of a motion by their keys in the profile, each in the unit that its key ends in.
[[nodiscard]] std::vector<std::pair<std::string_view, double>> motion_figures(const LayerMotion& motion);

// Returns the exposure time of layer `layer_index` (0 is the one on the plate). The fade is linear: fade
// layer k of n (from 1) is k/(n+1) of the way to the normal exposure. Not clamped: check with
// layer_height_problems() first. Throws std::range_error beyond a hundred years. REQUIRES: layer_index >= 0,
// layer_height > 0, irradiance > 0.
[[nodiscard]] Duration exposure_time(const ResinProfile& resin, Nanometers layer_height, int layer_index,
                                     double irradiance_mw_cm2);

// Returns, as a clause, what the profile lacks to expose undersides by dose; empty if it lacks nothing.
[[nodiscard]] std::string missing_for_dimming(const ResinProfile& resin);

// Returns a sentence with everything that the profile lacks for continuous printing; empty if it lacks
// nothing.
[[nodiscard]] std::string missing_for_continuous(const ResinProfile& resin);

// Makes the undersides plain if the profile lacks something to expose them by dose, and returns a sentence
// with the reason; empty if it lacks nothing.
[[nodiscard]] std::string settle_undersides(ResinProfile& resin);

// Returns the doses of layers, from the plate up, by exposure_time().
[[nodiscard]] std::vector<LayerDose> layer_doses(const ResinProfile& resin,
                                                 std::span<const Nanometers> thicknesses,
                                                 double irradiance_mw_cm2);

// The irradiance that exposures are computed with: the printer's, or any, where no printer is given.
enum class Irradiance { OfPrinter, Assumed };

// Returns the reasons, as clauses, why this layer height cannot be printed: it is outside the profile's
// range, or an exposure is outside kShortestExposure..kLongestExposure. REQUIRES: layer_height > 0,
// irradiance > 0.
[[nodiscard]] std::vector<std::string> layer_height_problems(const ResinProfile& resin,
                                                             Nanometers layer_height,
                                                             double irradiance_mw_cm2,
                                                             Irradiance of = Irradiance::OfPrinter);

}  // namespace contourd
