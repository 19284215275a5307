// Jobs that lie in printing/ and whose print is over: left there by a contourd that ended before it filed
// them, or as the disk did not take them. Event loop's thread only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/log.hpp"
#include "daemon/print_archivist.hpp"
#include "daemon/spool.hpp"

namespace contourd {

class UnfiledJobs {
 public:
  // Both must outlive it.
  UnfiledJobs(const Spool& spool, const Log& log) : spool_(spool), log_(log) {}

  // `end` is nothing when the print was interrupted.
  void add(const JobFiles& files, const std::optional<PrintEnd>& end) { jobs_.push_back({files, end}); }

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
  };

  const Spool& spool_;
  const Log& log_;
  std::vector<Job> jobs_;
};

}  // namespace contourd
