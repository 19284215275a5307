// Formats supports as text and as JSON: for the log, the report, the control socket and contourctl.
// Thread-safe (no shared state).
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/support/support_counts.hpp"
#include "core/support/support_settings.hpp"
#include "core/support/supports.hpp"

namespace contourd {

// Returns one line: "25 contacts (3 at islands, 20 at overhangs, 2 against peel), 14 branches, 9 feet, 0.33
// ml", "none needed", or "none added: 1 model carries its own in its file".
[[nodiscard]] std::string supports_line(const SupportCounts& supports);

// Returns "at 1.00, 2.00 mm from the plate's centre, 5.30 mm above the plate (island, 0.2 mm²): no path leads
// to the plate".
[[nodiscard]] std::string unheld_text(const UnheldPlace& place);
// Returns a sentence with the number of places and the first few of them; empty if there are none.
[[nodiscard]] std::string unheld_sentence(const std::vector<UnheldPlace>& places);
// Returns a sentence about supports that hold hairs, one about supports that cannot be taken out of sealed
// hollows, one about supports that fill gaps, one about overhangs over narrow gaps, and one about parts that
// the bottom exposures join to the plate, where there are any.
[[nodiscard]] std::vector<std::string> staying_sentences(const Supports& supports);
// Returns unheld_sentence() and staying_sentences().
[[nodiscard]] std::vector<std::string> supports_warnings(const Supports& supports);

// Returns the settings with the keys that they have in a resin's profile.
[[nodiscard]] nlohmann::ordered_json support_settings_json(const SupportSettings& settings);
// Returns the figures without the lists of supports_json().
[[nodiscard]] nlohmann::ordered_json supports_summary_json(const SupportCounts& supports);
// Reads the figures that supports_summary_json() wrote. Throws nlohmann::json::exception if one is missing.
[[nodiscard]] SupportCounts supports_in_summary(const nlohmann::ordered_json& summary);
// Returns the figures, every contact and every place that is not held.
[[nodiscard]] nlohmann::ordered_json supports_json(const Supports& supports);

}  // namespace contourd
