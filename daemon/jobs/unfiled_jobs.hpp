// Jobs in printing/ whose print is over: a former contourd ended before it filed them, or the disk did not
// accept them. Event loop's thread only, except JobFilingRun::run().
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/jobs/printer_use.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

// A job of printing/ that is to be filed. A value.
struct UnfiledJob {
  JobFiles files;
  JobEnd end;
  bool left = false;  // by another process: its end was not reported before
};

// Moves jobs out of printing/ on a thread that may wait for the disk. Not thread-safe: used by one thread
// after the other.
class JobFilingRun {
 public:
  explicit JobFilingRun(std::vector<UnfiledJob> jobs) : jobs_(std::move(jobs)) {}

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // Moves each job to the folder for its end, the first one first. Throws std::system_error; the remaining
  // jobs then stay in printing/.
  void run(Spool& spool);

 private:
  friend class UnfiledJobs;
  struct Filed {
    UnfiledJob job;
    ReportFiles reports;
    std::vector<std::string> troubles;
  };

  std::vector<UnfiledJob> jobs_;
  std::vector<Filed> filed_;
};

class UnfiledJobs {
 public:
  // All must outlive this object.
  UnfiledJobs(const Log& log, PrinterUse& use) : log_(log), use_(use) {}

  // Adds a job that another process left.
  void add_left(const JobFiles& files, const JobEnd& end) { jobs_.push_back({files, end, true}); }
  // Adds a job of this process, whose end was reported already.
  void add_known(const JobFiles& files, const JobEnd& end) { jobs_.push_back({files, end, false}); }

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // Returns the name of the job that was added last. REQUIRES: not empty.
  [[nodiscard]] const std::string& last() const {
    expects(!empty(), "there is a job");
    return jobs_.back().files.name;
  }

  // Returns all jobs for a run, the latest first; none while another run is under way.
  [[nodiscard]] JobFilingRun begin_filing();
  // Forgets the jobs that the run has filed, and reports their ends.
  void end_filing(const JobFilingRun& run);
  // Logs for each job that it stays in printing/ until the disk accepts it.
  void log_that_they_stay() const;

 private:
  const Log& log_;
  PrinterUse& use_;
  std::vector<UnfiledJob> jobs_;
  bool filing_ = false;
};

}  // namespace contourd
