// The record of a finished print, as its report has it. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "daemon/config/resin_profile.hpp"
#include "daemon/report/print_frames.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/report/printed_light.hpp"

namespace contourd::ctl {

struct RecordedPrint {
  std::string job, outcome;
  Undersides undersides = Undersides::Plain;  // as they were exposed
  std::vector<LayerRecord> layers;            // with light, as far as the cured part depends on them
  double irradiance_mw_cm2 = 0;
  double temperature_factor = 1;  // of the critical dose at the resin's temperature over that of the profile
  PrintFrames frames;
  std::int64_t unfound_undersides = 0;
  std::vector<Exclusion> exclusions;  // each of another copy, by rising layers
};

// Reads NAME.report.json, and the masks of a rise from NAME.frames.bin beside it. Throws ModelError if the
// report cannot be read, or is no report.
[[nodiscard]] RecordedPrint read_recorded_print(const std::filesystem::path& path);

// Returns the light of the print, in a resin that cures like this.
[[nodiscard]] PrintedLight light_of(const RecordedPrint& print, const CureSettings& cure);

}  // namespace contourd::ctl
