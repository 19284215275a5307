// The findings that users have accepted, each for the files that have it; files that have changed need a new
// acceptance. Saved on the disk, so that they survive a restart. Event loop's thread only.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/jobs/record_keeper.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

class Acceptances {
 public:
  using Lines = RecordKeeper::Lines;
  // Checks and log must outlive the acceptances.
  Acceptances(JobChecks& checks, const Log& log) : keeper_(checks, JobChecks::Record::Accepted, log) {}

  // Restores the acceptances that the last process saved.
  void load(Lines lines);

  // Accepts these findings, given by name, for jobs with this content: see content_mark().
  void add(const std::string& content, const std::vector<std::string>& findings);
  // Forgets all findings accepted for this content.
  void remove(const std::string& content);
  // Forgets one of them.
  void remove(const std::string& content, std::string_view finding);
  [[nodiscard]] bool has(const std::string& content, const std::string& finding) const;

  // Number of findings that are kept; the oldest are forgotten first.
  static constexpr std::size_t kMaxLines = 1'000;

 private:
  RecordKeeper keeper_;
  Lines lines_;  // "CONTENT FINDING"
};

// Returns a word that tells this content of a job from any other: a hash of the inodes, sizes and times of
// its files, including its ticket. A symbolic link counts as its target. Empty if these are not available: a
// file is gone, or a plate's ticket is broken. Blocks; thread-safe.
[[nodiscard]] std::string content_mark(const JobFiles& job);

}  // namespace contourd
