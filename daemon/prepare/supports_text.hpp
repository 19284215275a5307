// Supports in words and as JSON: for the log, the report, the control socket and contourctl. Thread-safe (no
// shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/support/support_settings.hpp"
#include "core/support/supports.hpp"
#include "daemon/prepare/support_counts.hpp"

namespace contourd {

// "25 contacts (3 islands, 20 overhangs, 2 peel), 14 branches, 9 feet, 0.33 ml"; "nothing has to be held".
[[nodiscard]] std::string supports_line(const SupportCounts& supports);

// "at 1.00, 2.00 mm from the plate's centre, 5.30 mm above the plate (island of 0.20 mm2): no path leads to
// the plate".
[[nodiscard]] std::string unheld_text(const UnheldPlace& place);
// A sentence about all of them, which names the first; empty when there are none.
[[nodiscard]] std::string unheld_sentence(const std::vector<UnheldPlace>& places);

// By their keys in a resin's profile.
[[nodiscard]] nlohmann::ordered_json support_settings_json(const SupportSettings& settings);
// The figures alone.
[[nodiscard]] nlohmann::ordered_json supports_summary_json(const SupportCounts& supports);
// The figures in what supports_summary_json() made. Throws nlohmann::json::exception where one is missing.
[[nodiscard]] SupportCounts supports_in_summary(const nlohmann::ordered_json& summary);
// With every contact and every place that is not held.
[[nodiscard]] nlohmann::ordered_json supports_json(const Supports& supports);

}  // namespace contourd
