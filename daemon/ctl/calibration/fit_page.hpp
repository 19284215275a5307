// A page about the result of a fit. Pure functions; thread-safe.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ctl/calibration/fitted_figures.hpp"

namespace contourd::ctl {

// Returns a value's name and unit between them: "measured um"; without a unit, the name.
[[nodiscard]] std::string with_unit(const std::string& name, const std::string& unit, const char* between);

// Returns the present value of a key, or "absent".
[[nodiscard]] std::string present_value(const nlohmann::ordered_json& file, const std::string& key);

// Returns a self-contained HTML page with the values, the plot, the measurements and the notes. `file`: the
// name of the file that the values are for; `before`: its content.
[[nodiscard]] std::string fit_page(const FitResult& result, const std::string& file,
                                   const nlohmann::ordered_json& before);

}  // namespace contourd::ctl
