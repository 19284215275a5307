// The time that a print and each of its layers take on a printer. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_plan.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Returns the duration of each of the plan's expected layers: exposure, moves and waits.
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer);
// Returns the duration of the whole print: the lamp's warm-up, homing from the height at which a print parks
// the plate, all expected layers, and parking. REQUIRES: the plan expects a layer.
[[nodiscard]] Duration print_duration(const PrintPlan& plan, const PrinterConfig& printer);

}  // namespace contourd
