// Jobs in printing/ whose print is over: a former contourd ended before it filed them, or the disk did not
// accept them. Event loop's thread only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/jobs/printer_use.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class UnfiledJobs {
 public:
  // All must outlive this object.
  UnfiledJobs(const Spool& spool, const Log& log, PrinterUse& use) : spool_(spool), log_(log), use_(use) {}

  // Adds a job that another process left. `end` is nullopt if its print was interrupted.
  void add_left(const JobFiles& files, const std::optional<PrintEnd>& end) {
    jobs_.push_back({files, end, true});
  }
  // Adds a job of this process, whose end was reported already.
  void add_known(const JobFiles& files, const PrintEnd& end) { jobs_.push_back({files, end, false}); }

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // Returns the name of the job that was added last. REQUIRES: not empty.
  [[nodiscard]] const std::string& last() const {
    expects(!empty(), "there is a job");
    return jobs_.back().files.name;
  }

  // Moves each job to the folder for its end, the latest first; a job without an end was interrupted, and has
  // failed. Throws std::system_error; the remaining jobs then stay in printing/.
  void file_all();
  // Logs for each job that it stays in printing/ until the disk accepts it.
  void log_that_they_stay() const;

 private:
  struct Job {
    JobFiles files;
    std::optional<PrintEnd> end;
    bool left = false;  // by another process: its end was not reported before
  };

  const Spool& spool_;
  const Log& log_;
  PrinterUse& use_;
  std::vector<Job> jobs_;
};

}  // namespace contourd
