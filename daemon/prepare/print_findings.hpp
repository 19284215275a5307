// What a whole-print analysis found, in words and as JSON: for the log, the report, the control socket and
// contourctl. Layers count from 1 here, as people count. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "core/analysis/print_analysis.hpp"

namespace contourd {

// "800 layers in 3 h 05 min, 12.34 ml of resin, ..."; without the time where none is known.
[[nodiscard]] std::string findings_line(const PrintFindings& findings);

// What may spoil the print: islands, suction cups, resin traps, empty layers, contours that did not close.
struct FindingWarning {
  std::string sentence;
  std::string_view mark;             // what is to be seen at those layers: "island"
  std::vector<std::int32_t> layers;  // that the sentence names, the first of each stretch; from 0
};
[[nodiscard]] std::vector<FindingWarning> findings_warnings(const PrintFindings& findings);
// Their sentences.
[[nodiscard]] std::vector<std::string> warnings_about(const PrintFindings& findings);

// The figures, and the warnings: for whoever asks while a print runs.
[[nodiscard]] nlohmann::ordered_json findings_summary_json(const PrintFindings& findings);
// The same with every island, suction cup, resin trap, empty layer and cracked layer.
[[nodiscard]] nlohmann::ordered_json findings_json(const PrintFindings& findings);

}  // namespace contourd
