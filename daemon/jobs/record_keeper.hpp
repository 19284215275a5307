// Saves the latest lines of a record on the disk, one write at a time, without blocking. Event loop's thread
// only.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "daemon/jobs/job_checks.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

class RecordKeeper {
 public:
  using Lines = std::vector<std::string>;
  // Checks and log must outlive the keeper. The same error is logged once.
  RecordKeeper(JobChecks& checks, JobChecks::Record record, const Log& log)
      : checks_(checks), record_(record), log_(log) {}

  // Sets the lines that the last process saved.
  void load(Lines lines) { wanted_ = kept_ = std::move(lines); }
  // Saves these lines, after a write that is under way.
  void keep(const Lines& lines);

 private:
  void keep_now();
  void note_trouble(const std::string& trouble);

  JobChecks& checks_;
  JobChecks::Record record_;
  const Log& log_;
  Lines wanted_, kept_;
  bool keeping_ = false;
  std::string trouble_;  // already logged
};

}  // namespace contourd
