#include "daemon/prepare/job_outlook.hpp"

#include <filesystem>
#include <system_error>

#include "daemon/json/config_error.hpp"
#include "daemon/spool/copied_originals.hpp"

namespace contourd {

namespace fs = std::filesystem;

namespace {

// Returns the total size of the job's files; a file that is gone counts as 0.
std::uintmax_t bytes_of(const JobFiles& files) {
  std::uintmax_t all = 0;
  try {
    for (const fs::path& part : parts_of(files)) {
      std::error_code gone;
      const std::uintmax_t bytes = fs::file_size(part, gone);
      if (!gone) all += bytes;
    }
  } catch (const ConfigError&) {
    // A plate's ticket that is being rewritten; the job is then checked again as well.
  }
  return all;
}

}  // namespace

JobOutlook outlook_of(const PreparedJob& job, const JobFiles& files, const PrinterConfig& printer) {
  const JobSummary& summary = job.summary;
  JobOutlook outlook{.bytes = bytes_of(files),
                     .resin = summary.resin.name,
                     .overridden = summary.overridden,
                     .layers = summary.layers.count,
                     .thinnest_layer = summary.layers.thinnest,
                     .thickest_layer = summary.layers.thickest,
                     .height_mm = summary.height_mm,
                     .supports = {},
                     .question = {}};
  if (summary.supports) outlook.supports = counts_of(*summary.supports);
  for (const ModelSummary& model : summary.models)
    outlook.parts += model.centers.size();
  outlook.forecast = forecast_of(job.plan, printer);
  return outlook;
}

}  // namespace contourd
