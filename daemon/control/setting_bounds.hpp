// The bounds of the settings that can be changed while it prints. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string_view>

#include "daemon/config/printer_config.hpp"
#include "daemon/config/ticket_limits.hpp"
#include "daemon/prepare/job_summary.hpp"

namespace contourd {

// Returns the bounds of a setting, one of kPrintSettings, from a layer on, counted from 0: those of a resin
// profile, of its ticket_limits and of the machine. The bounds of the exposure, in percent, keep every
// layer's exposure within them.
[[nodiscard]] Limits<double> setting_bounds(std::string_view setting, const JobSummary& job,
                                            const ResinMachine& machine, std::int32_t layer);

}  // namespace contourd
