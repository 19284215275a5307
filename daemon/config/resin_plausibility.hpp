// Warns of values in a resin's profile that the schema allows but that are probably mistakes, such as seconds
// instead of milliseconds, or mm/min instead of mm/s. Pure functions, thread-safe.
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {

// Returns the warnings. `file` is the profile's path. REQUIRES: irradiance > 0.
[[nodiscard]] std::vector<Violation> implausible_values(const ResinProfile& resin,
                                                        const std::filesystem::path& file,
                                                        double irradiance_mw_cm2);

}  // namespace contourd
