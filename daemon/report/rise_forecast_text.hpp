// Formats the plan of a continuous print as text and as JSON. Thread-safe (no shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/print/rise_forecast.hpp"

namespace contourd {

// Returns one line: "1 h 05 min: 58 min 10 s rising, 6 min in layers, 1 rest, 30 min".
[[nodiscard]] std::string continuous_line(const ContinuousForecast& forecast);
// Returns one line with the gap that resin flows through and the depth to which light cures through
// undersides, or with the reason why nothing is continuous.
[[nodiscard]] std::string gel_line(const ContinuousForecast& forecast);
// Returns a line for each of the first ranges: its heights, what holds its speed down, speeds, time,
// and for a rise the margin of its dose and the depth to which light cures through undersides.
[[nodiscard]] std::vector<std::string> range_lines(const ContinuousForecast& forecast);

// Returns the plan, and for each range how long it took; `took` is empty before the print.
[[nodiscard]] nlohmann::ordered_json continuous_json(const ContinuousForecast& forecast,
                                                     std::span<const std::optional<Duration>> took = {});
// Returns a table of the first ranges, as in range_lines(), for a page.
[[nodiscard]] std::string ranges_table(const ContinuousForecast& forecast,
                                       std::span<const std::optional<Duration>> took = {});

}  // namespace contourd
