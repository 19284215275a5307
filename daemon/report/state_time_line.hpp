// Where a print's time went, for its report: a time line as SVG with its pauses and interruptions, and a
// table of the states. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/report/print_report.hpp"

namespace contourd {

// Empty for a print that took no time.
[[nodiscard]] std::string state_time_line(const PrintReport& report);

// Each state that was entered with its time, by what it is drawn as. Empty for a print that took no time.
[[nodiscard]] std::string state_table(const StateTimes& states);

}  // namespace contourd
