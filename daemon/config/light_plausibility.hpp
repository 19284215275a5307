// Warns of a projector's table whose timing makes the light of a layer less certain than the resin tolerates.
#pragma once

#include "daemon/config/resin_profile.hpp"
#include "daemon/json/json_document.hpp"
#include "hw/real_machine_config.hpp"

namespace contourd {

// Adds warnings at the printer's /projector/table. `exposure` is the resin's shortest exposure.
void warn_of_implausible_light(JsonDocument& printer, const ProjectorConfig& projector,
                               const ExposureTolerance& tolerance, Duration exposure);

}  // namespace contourd
