// The time that the ranges of a continuous print took. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "daemon/report/print_report.hpp"

namespace contourd {

// Returns the time that each of these ranges of a print's plan took, as ContinuousRange::time, without pauses
// and without the rest before it; nullopt for a range that the print did not complete, or that it began
// before a power cut. The lift after a layer counts for what follows it. A range that was planned again from
// within has all of its time.
[[nodiscard]] std::vector<std::optional<Duration>> range_times(const PrintReport& report,
                                                               std::span<const ContinuousRange> ranges);

}  // namespace contourd
