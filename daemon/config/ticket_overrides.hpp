// A ticket's own settings put in the place of its resin's, within what the resin's profile allows. Pure
// functions, thread-safe.
#pragma once

#include <filesystem>
#include <string>

#include "daemon/config/job_ticket.hpp"
#include "daemon/config/resin_profile.hpp"
#include "daemon/config/ticket_limits.hpp"

namespace contourd {

// What messages name.
struct OverrideFiles {
  std::string ticket;
  std::filesystem::path profile;
};

// Nothing is clamped: throws ConfigError with everything that the profile does not allow, each with the value
// that was asked for and the limits. An exposure for a resin with a working curve makes both of its exposures
// fixed ones, for this ticket's layer height. REQUIRES: irradiance > 0.
[[nodiscard]] OverriddenSettings override_settings(ResinProfile& resin, const JobTicket& ticket,
                                                   double irradiance_mw_cm2, const OverrideFiles& files);

}  // namespace contourd
