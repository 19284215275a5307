// The record of a finished print, as its report has it. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/report/printed_light.hpp"

namespace contourd::ctl {

struct RecordedPrint {
  std::string job, outcome;
  Undersides undersides = Undersides::Plain;  // as they were exposed
  PrintedLight light;
  // Lit areas by layer; nullopt for a slice of a rise, which several masks lit.
  std::vector<std::optional<double>> areas_mm2;
  std::int64_t unfound_undersides = 0;
};

// Reads NAME.report.json. Throws ModelError if the file cannot be read, or is no such report.
[[nodiscard]] RecordedPrint read_recorded_print(const std::filesystem::path& path);

}  // namespace contourd::ctl
