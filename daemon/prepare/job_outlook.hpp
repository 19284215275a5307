// What a job that waits will be, as far as its check can tell. A value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/units.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/preprint_analysis.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/prepare/support_counts.hpp"
#include "daemon/spool/job_files.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct JobOutlook {
  std::uintmax_t bytes = 0;  // of its files
  std::size_t parts = 0;     // on the plate: models and their copies
  std::string resin{};       // the profile's name
  OverriddenSettings overridden{};
  std::int32_t layers = 0;
  Nanometers thinnest_layer{}, thickest_layer{};
  double height_mm = 0;
  Duration print_time{};                    // of its layers
  std::optional<SupportCounts> supports{};  // nothing where none are wanted
  std::optional<AnalyzedJob> question{};    // which is asked whatever the printer's file names
};

// Looks at the files' sizes. Thread-safe.
[[nodiscard]] JobOutlook outlook_of(const PreparedJob& job, const JobFiles& files,
                                    const PrinterConfig& printer);

}  // namespace contourd
