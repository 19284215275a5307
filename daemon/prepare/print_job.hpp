// From a model's file and its ticket, or a plate's folder, to a print that can begin: read, placed, checked
// against the machine, its first mask computed. Thread-safe (no shared state): runs on the worker's thread.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "core/analysis/print_analysis.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/prepare/job_settings.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/prepare/plate_arrangement.hpp"
#include "daemon/print/print_process.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

struct PreparedJob {
  PrintPlan plan;
  // The same engine once more, with the same settings: to look through the whole print beside it.
  std::unique_ptr<ContourEngine> analysis_engine;
  DisplayGeometry display;
  AnalysisOptions analysis;
  JobSummary summary;
  JobSettings settings;       // by which it was prepared
  TimePoint first_mask_at{};  // CLOCK_MONOTONIC, whatever clock the machine runs by
};

// Blocks: a few hundred milliseconds for a million facets. Throws JobRefused, of which JobTooLarge says that
// there is no room for it in memory; then nothing was read.
[[nodiscard]] PreparedJob prepare_job(const JobFiles& files, const JobSettings& settings,
                                      const PrinterConfig& printer);
// The same; nothing when `stop` was asked for while supports were made.
[[nodiscard]] std::optional<PreparedJob> prepare_job(const JobFiles& files, const JobSettings& settings,
                                                     const PrinterConfig& printer,
                                                     const std::stop_token& stop);

}  // namespace contourd
