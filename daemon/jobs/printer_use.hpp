// Interface of the printer to its queue. Event loop's thread only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/history/job_history.hpp"
#include "daemon/placement/job_settings.hpp"
#include "daemon/progress/interrupted_print.hpp"
#include "daemon/spool/job_files.hpp"
#include "hw/clock.hpp"

namespace contourd {

// A job whose turn has come. A value.
struct ClaimedJob {
  JobFiles files;  // in printing/
  // The settings when its turn came; nullopt if its ticket is a reason to refuse it.
  std::optional<JobSettings> settings;
  TimePoint turn_came;                  // time of its arrival, or of the end of its wait; CLOCK_MONOTONIC
  std::vector<std::string> accepted{};  // findings of the preparation that a user accepted
  // How far its print was when a power cut ended it, and where it goes on; nullopt: the print begins.
  struct Resumed {
    InterruptedPrint print;
    ResumePoint point;
  };
  std::optional<Resumed> resumed{};
};

// Present use of the printer, on which it depends whether a job may begin.
class PrinterUse {
 public:
  virtual ~PrinterUse() = default;

  // True if a job is claimed and not filed yet.
  [[nodiscard]] virtual bool has_job() const = 0;
  [[nodiscard]] virtual bool controlled_by_hand() const = 0;
  // Reads and prints the job. REQUIRES: !has_job().
  virtual void begin(ClaimedJob job) = 0;
  // Reports that a stop of contourd may have nothing more to wait for.
  virtual void may_stop() = 0;
  // Reports that a job may begin, or that the disk has refused the records of the hold.
  virtual void hold_changed() = 0;
  // Reports a job that the last process left in printing/ and that is filed now.
  virtual void left_job_filed(const EndedJob& job) = 0;
};

}  // namespace contourd
