// Formats the settings in which a ticket overrides its resin's profile, as text and as JSON. Thread-safe (no
// shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/config/ticket_limits.hpp"

namespace contourd {

// Returns "exposure_ms 4000 instead of 3000, lift_mm 8 instead of 6"; empty if nothing is overridden.
[[nodiscard]] std::string describe(const OverriddenSettings& overridden);

// Returns a list of objects: setting, asked, profile.
[[nodiscard]] nlohmann::ordered_json overrides_json(const OverriddenSettings& overridden);

}  // namespace contourd
