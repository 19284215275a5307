// What a print was made with and has used so far, for the history. Thread-safe (no shared state).
#pragma once

#include <vector>

#include "daemon/history/job_history.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

// Of a print under way; its interruptions and late steps are known at its end.
[[nodiscard]] JobFigures figures_of(const JobSummary& summary, const std::vector<LayerRecord>& layers,
                                    Duration print_time);
// Of one that is over.
[[nodiscard]] JobFigures figures_of(const PrintReport& report);

}  // namespace contourd
