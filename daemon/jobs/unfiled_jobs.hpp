// Jobs that lie in printing/ and whose print is over: left there by a contourd that ended before it filed
// them, or as the disk did not take them. Event loop's thread only.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/jobs/print_archivist.hpp"
#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class UnfiledJobs {
 public:
  using Filed = std::function<void(const EndedJob&)>;
  // Spool and log must outlive it. `filed` is told of those whose end nobody has heard of.
  UnfiledJobs(const Spool& spool, const Log& log, Filed filed)
      : spool_(spool), log_(log), filed_(std::move(filed)) {}

  // Left by another process. `end` is nothing when the print was interrupted.
  void add_left(const JobFiles& files, const std::optional<PrintEnd>& end) {
    jobs_.push_back({files, end, true});
  }
  // One of this process', whose end is known already.
  void add_known(const JobFiles& files, const PrintEnd& end) { jobs_.push_back({files, end, false}); }

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // REQUIRES: not empty.
  [[nodiscard]] const std::string& last() const {
    expects(!empty(), "there is a job");
    return jobs_.back().files.name;
  }

  // Moves each to where its end says; one without an end was interrupted, and has failed. The latest is the
  // first. Throws std::system_error; the rest of them stays where it is.
  void file_all();
  // Logs of each that it stays in printing/ until the disk takes it.
  void tell_they_stay() const;

 private:
  struct Job {
    JobFiles files;
    std::optional<PrintEnd> end;
    bool tell = false;
  };

  const Spool& spool_;
  const Log& log_;
  Filed filed_;
  std::vector<Job> jobs_;
};

}  // namespace contourd
