// What a job's ticket sets in the place of its resin's profile, and between which values that profile lets
// it. Value types; thread-safe.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "core/geometry/units.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The keys of these settings: in a ticket, in a profile, and in a profile's ticket_limits.
inline constexpr std::array<std::string_view, 5> kTicketSettings{"exposure_ms", "bottom_exposure_ms",
                                                                 "lift_mm", "settle_ms", "rest_ms"};

// As a ticket asks for them; not yet checked against the profile.
struct TicketOverrides {
  std::optional<Duration> exposure, bottom_exposure;
  std::optional<Nanometers> lift;
  std::optional<Duration> settle, rest;
  bool operator==(const TicketOverrides&) const = default;
};

// Both belong to it.
template <typename Quantity>
struct Limits {
  Quantity least{}, most{};
  [[nodiscard]] bool contain(Quantity value) const { return value >= least && value <= most; }
  bool operator==(const Limits&) const = default;
};

// What has none, no ticket may set.
struct TicketLimits {
  std::optional<Limits<Duration>> exposure, bottom_exposure;
  std::optional<Limits<Nanometers>> lift;
  std::optional<Limits<Duration>> settle, rest;
  bool operator==(const TicketLimits&) const = default;
};

// A setting by which a job is printed because its ticket says so.
struct OverriddenSetting {
  // Of kTicketSettings, or of support_figures(); it ends in the unit of the other two.
  std::string_view setting;
  double asked = 0;
  double profile = 0;  // what the job would have been printed with
  bool operator==(const OverriddenSetting&) const = default;
};
using OverriddenSettings = std::vector<OverriddenSetting>;

}  // namespace contourd
