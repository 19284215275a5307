// The time that a print and each of its layers take on a printer. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_plan.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Returns the duration of each of the plan's expected layers: exposure, moves and waits, or its part of a
// rise. The rest and the moves before a rise count for its first layer, the lift after it for its last.
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer);
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const ZAxis& axis);
// Returns, by expected layer, the time from its begin to the end of the print, with parking; and for the
// number of layers the time of parking alone.
[[nodiscard]] std::vector<Duration> durations_to_end(const PrintPlan& plan, const ZAxis& axis);
// Returns the duration of the whole print: the lamp's warm-up, homing from the height at which a print parks
// the plate, all expected layers, and parking. REQUIRES: the plan expects a layer.
[[nodiscard]] Duration print_duration(const PrintPlan& plan, const PrinterConfig& printer);

}  // namespace contourd
