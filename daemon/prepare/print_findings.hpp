// Formats the findings of a whole-print analysis as text and as JSON: for the log, the report, the control
// socket and contourctl. Layers count from 1 here, as people count. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/analysis/print_analysis.hpp"

namespace contourd {

// Returns one line: "800 layers in 3 h 05 min, 12.34 ml of resin, ..."; without the time if it is unknown.
[[nodiscard]] std::string findings_line(const PrintFindings& findings);

// A warning of something that may spoil the print: islands, suction cups, resin traps, empty layers, contours
// that did not close.
struct FindingWarning {
  std::string sentence;
  std::string_view mark;             // label for pictures of these layers: "island"
  std::vector<std::int32_t> layers;  // named in the sentence, the first of each run; from 0
};
// Returns a warning for each kind of finding.
[[nodiscard]] std::vector<FindingWarning> findings_warnings(const PrintFindings& findings);
// Returns the sentences of findings_warnings().
[[nodiscard]] std::vector<std::string> warnings_about(const PrintFindings& findings);

// Returns the figures of cracks, of a layer or of many.
[[nodiscard]] nlohmann::ordered_json cracks_json(const LayerCracks& cracks);
// Returns the figures and the warnings, as the control socket sends them while a print runs.
[[nodiscard]] nlohmann::ordered_json findings_summary_json(const PrintFindings& findings);
// Returns the summary and the lists of every island, suction cup, resin trap, empty layer and cracked layer.
[[nodiscard]] nlohmann::ordered_json findings_json(const PrintFindings& findings);

}  // namespace contourd
