// Warns of values that the schema allows and a resin's profile hardly means: seconds for milliseconds, a
// speed a minute for one a second. Pure functions, thread-safe.
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"

namespace contourd {

// `file` is the profile's. REQUIRES: irradiance > 0.
[[nodiscard]] std::vector<Violation> implausible_values(const ResinProfile& resin,
                                                        const std::filesystem::path& file,
                                                        double irradiance_mw_cm2);

}  // namespace contourd
