// Figures with which CurrentJob reports a print to the history: its settings, and the light, time and resin
// used so far. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/history/job_history.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

// Returns the figures of a print under way. Its interruptions and late steps are known only at its end.
[[nodiscard]] JobFigures figures_of(const JobSummary& summary, const std::vector<LayerRecord>& layers,
                                    Duration print_time);
// Returns the figures of a print that is over.
[[nodiscard]] JobFigures figures_of(const PrintReport& report);

}  // namespace contourd
