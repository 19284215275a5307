// Formats the time of a print by cause, as forecast and as it was, for people and as JSON. Thread-safe (no
// shared state).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "daemon/print/layer_durations.hpp"
#include "daemon/report/print_report.hpp"

namespace contourd {

// Returns the causes in which a completed print differs from its forecast by more than a fiftieth of the
// print's expected time, the accuracy of forecasts, and by more than 5 s, within which homing and the answers
// of devices vary. Empty for any other print.
[[nodiscard]] std::vector<TimeCause> differing_causes(const PrintReport& report);

// Returns "1 h 05 min: 40 min light, 12 min 30 s lifting, ...", the longest time first.
[[nodiscard]] std::string causes_line(const TimeByCause& time);
// Returns lines with the times of the print, and of its typical and its longest layer.
[[nodiscard]] std::vector<std::string> forecast_lines(const PrintForecast& forecast);

// Returns an object of seconds by cause, with all causes.
[[nodiscard]] nlohmann::ordered_json causes_json(const TimeByCause& time);
[[nodiscard]] nlohmann::ordered_json forecast_json(const PrintForecast& forecast);
// Returns the forecast and the time that the print took.
[[nodiscard]] nlohmann::ordered_json times_json(const PrintReport& report);

// Return tables for a page; that of a print without a forecast is empty.
[[nodiscard]] std::string forecast_table(const PrintForecast& forecast);
[[nodiscard]] std::string times_table(const PrintReport& report);

}  // namespace contourd
