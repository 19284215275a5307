// The distribution of a print's time over its states, for its report: a time line as SVG with pauses and
// interruptions, and a table of the states. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/report/print_report.hpp"

namespace contourd {

// Draws the time line as SVG. Empty for a print that took no time.
[[nodiscard]] std::string state_time_line(const PrintReport& report);

// Returns a table of the states that were entered, with their times, grouped by activity. Empty for a print
// that took no time.
[[nodiscard]] std::string state_table(const StateTimes& states);

}  // namespace contourd
