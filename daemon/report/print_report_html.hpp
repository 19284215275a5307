// A print's report as one self-contained HTML page: a picture, the settings, the times, plots against height.
// Thread-safe (no shared state).
#pragma once

#include <string>

#include "daemon/report/print_report.hpp"

namespace contourd {

[[nodiscard]] std::string report_as_html(const PrintReport& report);

}  // namespace contourd
