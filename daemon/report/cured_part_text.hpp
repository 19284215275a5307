// The figures of a cured part as text and JSON: for contourctl cure and the report of a print. Thread-safe
// (no shared state).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/cure/cured_part.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/report/printed_light.hpp"

namespace contourd {

// Returns "at 1.00, 2.00 mm, 3.00 mm above the plate".
[[nodiscard]] std::string place_text(const CurePlace& place);
// Returns one line: median, 95 %, worst and its place; what is missing.
[[nodiscard]] std::string distances_text(const SurfaceDistances& distances);

// A figure's name and its text.
struct CureLine {
  std::string name, text;
};
// Returns the lines that describe the part.
[[nodiscard]] std::vector<CureLine> cured_part_lines(const CuredPart& part);

// Returns the line that describes the light of a rise.
[[nodiscard]] CureLine rise_light_line(const RiseLight& rise);
[[nodiscard]] nlohmann::ordered_json rise_light_json(const RiseLight& rise);

// Returns sentences about the part and what is unknown about it.
[[nodiscard]] std::vector<std::string> cured_part_warnings(const CuredPart& part, bool memory_measured);

// Does the same for the part of a report; none if there is no part.
[[nodiscard]] std::vector<std::string> warnings_of(const PrintedPart& cured, bool memory_measured);

// Return the widths and shares of a pixel's Gaussians: "sigma 0.45 pixels".
[[nodiscard]] std::string pixel_light_text(const PixelLight& light);
[[nodiscard]] nlohmann::ordered_json pixel_light_json(const PixelLight& light);

// Returns the figures, without warnings.
[[nodiscard]] nlohmann::ordered_json cured_part_json(const CuredPart& part);

}  // namespace contourd
