// How long the layers of a print take on a printer. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_process.hpp"
#include "hw/clock.hpp"

namespace contourd {

// Of each of the plan's expected layers: light, moves and waits.
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer);

}  // namespace contourd
