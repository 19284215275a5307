// The light of a print by the resin's temperature: warm resin needs less. Thread-safe (no shared state).
#pragma once

#include <stdexcept>

#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/print_job.hpp"

namespace contourd {

// Reads the temperature in degrees Celsius. Blocks for up to a second, as long as a 1-Wire sensor takes.
// Throws std::runtime_error with a clause if the sensor cannot be read or is out of 0 to 80 degrees.
[[nodiscard]] double read_temperature(const ResinTemperature& from);

// Makes the exposures of a prepared job those for the resin's present temperature: the critical dose of its
// working curve changes by Arrhenius' law (at_temperature()) and all exposures in proportion, so that every
// cure depth stays. The rises of a continuous print are planned again by this curve, see plan_rises_of().
// More than 20 degrees beside the curve's temperature count as 20. Does nothing for a profile with fixed
// exposures, or if the temperature of resin or curve is not configured. If the sensor cannot be read or an
// exposure would be outside kShortestExposure..kLongestExposure, the light stays that of the profile, with a
// warning. May be called again, for the temperature of another time. Blocks as read_temperature() does.
void follow_temperature(PreparedJob& job, const PrinterConfig& printer);

}  // namespace contourd
