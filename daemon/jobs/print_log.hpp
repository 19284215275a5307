// Log lines about a print: the job, its findings, each layer and its light, interruptions, and the end. Event
// loop's thread only.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/jobs/print_analyst.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/print/print_mode.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class PrintLog {
 public:
  // The log must outlive this object.
  explicit PrintLog(const Log& log) : log_(log) {}

  // Logs that the job is refused and not printed.
  void refused(const std::string& job, const std::string& reason) const;
  void ready(const std::string& job, const JobSummary& summary, Duration first_mask_after) const;
  void analyzed(const std::string& job, const AnalyzedPrint& print) const;
  // Logs the state if it lasts, or if the user should know of it.
  void entered(const std::string& job, const PrintState& state) const;
  // Logs a printed layer. `frame` is one refresh of the display: light that was on for longer than requested
  // by more than `frame` causes a warning.
  void layer(const std::string& job, const JobSummary& summary, const LayerRecord& layer,
             Duration frame) const;
  // Logs an interruption in `layer`, counted from 0. `dark` is true if the light is known to be off.
  void interrupted(const std::string& job, std::int32_t layer, const std::string& what, bool dark) const;
  void ended(const PrintReport& report) const;

 private:
  void warn_about_light(const JobSummary& summary, const LayerRecord& layer, Duration frame,
                        const LogFields& fields) const;
  // Logs one line for each kind of trouble with the layers' contours, however many layers have it.
  void warn_about_sections(const PrintReport& report) const;
  void warn_about_lateness(const PrintReport& report) const;

  const Log& log_;
};

}  // namespace contourd
