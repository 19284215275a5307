// Warns of values in a printer's file and in a resin's profile that the schema allows but that are probably
// mistakes. Thread-safe (no shared state).
#pragma once

#include <filesystem>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/json/config_error.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Adds warnings at the printer's /projector/table if its timing makes the light of a layer less certain than
// the resin tolerates. `exposure` is the resin's shortest exposure.
void warn_of_implausible_light(JsonDocument& printer, const ProjectorConfig& projector,
                               const ExposureTolerance& tolerance, Duration exposure);

// Adds warnings about values in the printer's /display.
void warn_of_implausible_display(JsonDocument& printer);

// Adds warnings of switches, an emergency stop or a lid whose broken wire would go unnoticed. Ignores
// contacts without defaults; run printer_schema() first, which sets them.
void warn_of_implausible_contacts(JsonDocument& printer);

// Returns warnings of a resin's values, such as seconds instead of milliseconds, or mm/min instead of mm/s.
// `file` is the profile's path. REQUIRES: irradiance > 0.
[[nodiscard]] std::vector<Violation> implausible_values(const ResinProfile& resin,
                                                        const std::filesystem::path& file,
                                                        double irradiance_mw_cm2);

}  // namespace contourd
