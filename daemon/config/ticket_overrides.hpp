// Applies a ticket's settings to a resin's profile, within the limits of the profile. Pure functions,
// thread-safe.
#pragma once

#include <filesystem>
#include <string>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/config/ticket_limits.hpp"

namespace contourd {

// The files to name in messages.
struct OverrideFiles {
  std::string ticket;
  std::filesystem::path profile;
};

// Replaces the settings of `resin` that the ticket overrides, and returns them. Does not clamp: throws
// ConfigError with every value that the profile does not allow and its limits. If the ticket sets an exposure
// for a resin with a working curve, both exposures become fixed ones, for this ticket's layer height.
// REQUIRES: irradiance > 0.
[[nodiscard]] OverriddenSettings override_settings(ResinProfile& resin, const JobTicket& ticket,
                                                   double irradiance_mw_cm2, const OverrideFiles& files);

}  // namespace contourd
