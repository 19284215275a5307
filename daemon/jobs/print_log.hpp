// A print's lines in the log: what the job is, what is found in it, each layer and its light, what interrupts
// it, how it ends. Event loop's thread only.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/jobs/print_analyst.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/print/print_states.hpp"
#include "daemon/report/print_report.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class PrintLog {
 public:
  // The log must outlive it.
  explicit PrintLog(const Log& log) : log_(log) {}

  // It is not printed.
  void refused(const std::string& job, const std::string& reason) const;
  void ready(const std::string& job, const JobSummary& summary, Duration first_mask_after) const;
  void analyzed(const std::string& job, const AnalyzedPrint& print) const;
  // A line for those states that last, or that an owner should know of.
  void entered(const std::string& job, PrintState state) const;
  // `frame` is one refresh of the display: light that lasts longer by more than that is warned of.
  void layer(const std::string& job, const JobSummary& summary, const LayerRecord& layer,
             Duration frame) const;
  // `layer` counts from 0.
  void interrupted(const std::string& job, std::int32_t layer, const std::string& what, bool dark) const;
  void ended(const PrintReport& report) const;

 private:
  void warn_about_light(const JobSummary& summary, const LayerRecord& layer, Duration frame,
                        const LogFields& fields) const;
  void warn_about_section(const JobSummary& summary, const LayerRecord& layer, const LogFields& fields) const;
  void warn_about_lateness(const PrintReport& report) const;

  const Log& log_;
};

}  // namespace contourd
