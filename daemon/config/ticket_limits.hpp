// The settings of a resin's profile that a job's ticket can override, and the limits that the profile sets
// for this. Value types; thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The keys of these settings in a ticket, in a profile and in a profile's ticket_limits.
inline constexpr std::array<std::string_view, 5> kTicketSettings{"exposure_ms", "bottom_exposure_ms",
                                                                 "lift_mm", "settle_ms", "rest_ms"};
// A ticket's exposures by height, as a list of overridden settings names each of them.
inline constexpr std::string_view kExposureSteps = "exposure_steps.exposure_ms";

// The exposure of the normal layers whose middles are at least so high above the plate.
struct ExposureStep {
  Nanometers from{};
  Duration exposure{};
  bool operator==(const ExposureStep&) const = default;
};

// The light of a solid's lowest layers: that of all others, or as much as cures the underside at its drawn
// height (see UndersideDimming).
enum class Undersides { Plain, Dose };
// Returns Dose for "dose"; Plain for any other name.
[[nodiscard]] inline Undersides undersides_of(std::string_view name) {
  return name == "dose" ? Undersides::Dose : Undersides::Plain;
}

// The way of a print: layer by layer to its end, or with a plate that rises without a stop.
enum class PrintWay { Layered, Continuous };
// Returns Continuous for "continuous"; Layered for any other name.
[[nodiscard]] inline PrintWay print_way_of(std::string_view name) {
  return name == "continuous" ? PrintWay::Continuous : PrintWay::Layered;
}

// The values that a ticket asks for; not yet checked against the profile.
struct TicketOverrides {
  std::optional<Duration> exposure, bottom_exposure;
  std::vector<ExposureStep> exposure_steps{};  // rising
  std::optional<Nanometers> lift;
  std::optional<Duration> settle, rest;
  bool operator==(const TicketOverrides&) const = default;
};

// A closed interval.
template <typename Quantity>
struct Limits {
  Quantity least{}, most{};
  [[nodiscard]] bool contain(Quantity value) const { return value >= least && value <= most; }
  bool operator==(const Limits&) const = default;
};

// The limits for a ticket's values. A setting without limits cannot be overridden.
struct TicketLimits {
  std::optional<Limits<Duration>> exposure, bottom_exposure;
  std::optional<Limits<Nanometers>> lift;
  std::optional<Limits<Duration>> settle, rest;
  bool operator==(const TicketLimits&) const = default;
};

// A setting whose value comes from the job's ticket instead of the resin's profile.
struct OverriddenSetting {
  // The key, one of kTicketSettings or of support_figures(), or kExposureSteps; it ends in the unit of the
  // two values.
  std::string_view setting;
  double asked = 0;
  double profile = 0;  // the value without the ticket
  bool operator==(const OverriddenSetting&) const = default;
};
using OverriddenSettings = std::vector<OverriddenSetting>;

}  // namespace contourd
