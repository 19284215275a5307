// Figures of a waiting job, as far as its check can predict them. A value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/geometry/units.hpp"
#include "core/support/support_counts.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/print/layer_durations.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

// A waiting job's size, settings, layers and print time.
struct JobOutlook {
  std::uintmax_t bytes = 0;  // size of the job's files
  std::size_t parts = 0;     // number on the plate: models and their copies
  std::string resin{};       // name of the profile
  OverriddenSettings overridden{};
  std::int32_t layers = 0;
  Nanometers thinnest_layer{}, thickest_layer{};
  double height_mm = 0;
  PrintForecast forecast{};                 // of its time
  std::optional<SupportCounts> supports{};  // nullopt if the job has supports off
  std::optional<AnalyzedJob> question{};    // findings that need confirmation even if ask_before is empty
};

// Returns the outlook of a prepared job. Reads the sizes of its files. Thread-safe.
[[nodiscard]] JobOutlook outlook_of(const PreparedJob& job, const JobFiles& files,
                                    const PrinterConfig& printer);

}  // namespace contourd
