// A print's report as JSON, for programs. Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/report/print_report.hpp"

namespace contourd {

[[nodiscard]] std::string report_as_json(const PrintReport& report);

}  // namespace contourd
