// Prepares a job, a model's file and its ticket or a plate's folder, for printing: reads and places the
// models, checks them against the machine and computes the first mask. Thread-safe (no shared state): runs on
// the worker's thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>

#include "core/analysis/print_analysis.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/placement/plate_arrangement.hpp"
#include "daemon/prepare/job_summary.hpp"
#include "daemon/print/print_plan.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

// A job that is ready to print.
struct PreparedJob {
  PrintPlan plan;
  // A copy of the plan's engine with the same settings, to analyze all layers while the print runs.
  std::unique_ptr<ContourEngine> analysis_engine;
  DisplayGeometry display;
  AnalysisOptions analysis;
  JobSummary summary;
  JobSettings settings;  // with which the job was prepared
  // By which the rises of a continuous print are planned; null: it was to be layered from the beginning.
  std::shared_ptr<const std::vector<RiseSlab>> slabs{};
  TimePoint first_mask_at{};  // CLOCK_MONOTONIC, whatever clock the machine runs by
};

// Plans the rises of a job by its slabs and the working curve of its summary, and puts plan, forecast and
// warnings into the job in place of those before. A job in which no rise is possible is layered, with a
// warning. Does nothing for a job without slabs.
void plan_rises_of(PreparedJob& job, const PrinterConfig& printer);
// Returns the exposure of each layer by this profile, for PrintPlan::exposure.
[[nodiscard]] std::function<Duration(std::int32_t layer, Nanometers thickness)> exposure_by(
    const ResinProfile& resin, double irradiance_mw_cm2);
// Returns the settings of the engine that makes the masks of a print. The values of masks whose exposures are
// split are linear.
[[nodiscard]] EngineSettings engine_settings(const PrinterConfig& printer, const ResinProfile& resin);

// Prepares the job. Throws JobRefused; JobTooLarge if there is not enough memory for it, in most cases before
// its files are read. Blocks for a few hundred milliseconds per million facets.
[[nodiscard]] PreparedJob prepare_job(const JobFiles& files, const JobSettings& settings,
                                      const PrinterConfig& printer);
// Does the same, and returns nullopt if `stop` was requested before the job was ready.
[[nodiscard]] std::optional<PreparedJob> prepare_job(const JobFiles& files, const JobSettings& settings,
                                                     const PrinterConfig& printer,
                                                     const std::stop_token& stop);

}  // namespace contourd
