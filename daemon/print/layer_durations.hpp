// The time that each layer of a print takes on a printer. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_plan.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Returns the duration of each of the plan's expected layers: exposure, moves and waits.
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer);

}  // namespace contourd
