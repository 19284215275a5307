// The time that a print and each of its layers take on a printer, by cause. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_mode.hpp"
#include "daemon/print/print_plan.hpp"
#include "hw/clock.hpp"

namespace contourd {

// The time that a layer takes, or a slice of a rise.
struct LayerTime {
  std::int32_t layer = 0;  // from 0
  TimeByCause time{};
};

// The expected time of a print.
struct PrintForecast {
  TimeByCause time{};   // of the whole print
  LayerTime typical{};  // half of the layers take longer
  LayerTime longest{};  // the first one that takes the longest
};

// Returns the duration of each of the plan's expected layers: exposure, moves and waits, or its part of a
// rise. The rest and the moves before a rise count for its first layer, the lift after it for its last.
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const PrinterConfig& printer);
[[nodiscard]] std::vector<Duration> layer_durations(const PrintPlan& plan, const ZAxis& axis);
// Returns, by expected layer, the time from its begin to the end of the print, with parking; and for the
// number of layers the time of parking alone.
[[nodiscard]] std::vector<Duration> durations_to_end(const PrintPlan& plan, const ZAxis& axis);
// Returns the time of the whole print: the lamp's warm-up, homing from the height at which a print parks
// the plate, all expected layers, and parking. A print that goes on after a power cut has only its layers
// from there on. Screen and projector are expected to answer at once. REQUIRES: the plan expects a layer.
[[nodiscard]] PrintForecast forecast_of(const PrintPlan& plan, const PrinterConfig& printer);

}  // namespace contourd
