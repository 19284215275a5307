// What a ticket sets in the place of its resin's profile, in words and as JSON. Thread-safe (no shared
// state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/config/ticket_limits.hpp"

namespace contourd {

// "exposure_ms 4000 instead of 3000, lift_mm 8 instead of 6"; empty where there is none.
[[nodiscard]] std::string describe(const OverriddenSettings& overridden);

// A list of these.
[[nodiscard]] nlohmann::ordered_json overrides_json(const OverriddenSettings& overridden);

}  // namespace contourd
