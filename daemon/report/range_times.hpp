// The time that the ranges of a continuous print took. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "daemon/report/print_report.hpp"

namespace contourd {

// Returns the time that each range of the print's plan took, as ContinuousRange::time, without pauses and
// without the rest before it; nullopt for a range that the print did not complete, or that it began before a
// power cut. The lift after a layer counts for what follows it. Empty if the print had no such plan.
[[nodiscard]] std::vector<std::optional<Duration>> range_times(const PrintReport& report);

}  // namespace contourd
