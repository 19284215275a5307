// What owners have accepted: of which files, and which findings. Kept on the disk, so that it is the same
// after a restart. Files that have changed are others. Event loop's thread only.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/jobs/record_keeper.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

class Acceptances {
 public:
  using Lines = RecordKeeper::Lines;
  // As RecordKeeper's.
  Acceptances(RecordKeeper::Keep keep, std::function<void(const std::string& trouble)> failed)
      : keeper_(std::move(keep), std::move(failed)) {}

  // What the last process has kept.
  void load(Lines lines);

  // Of jobs with these contents; findings by their names.
  void add(const std::string& content, const std::vector<std::string>& findings);
  void remove(const std::string& content);
  [[nodiscard]] bool has(const std::string& content, const std::string& finding) const;

  // The oldest are forgotten beyond so many findings.
  static constexpr std::size_t kMost = 1'000;

 private:
  RecordKeeper keeper_;
  Lines lines_;  // "CONTENT FINDING"
};

// What tells a job's contents from all others': inodes, sizes and times of its files, its ticket among them,
// in one word. Those of a symbolic link are its file's. Empty when they cannot be had: a file is gone, or a
// plate's ticket is broken. Blocks; thread-safe.
[[nodiscard]] std::string content_mark(const JobFiles& job);

}  // namespace contourd
