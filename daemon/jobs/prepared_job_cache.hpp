// The next job as its check has prepared it, kept until its turn comes, so that it is not prepared again when
// nothing has changed. Holds the job's memory. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/prepare/job_settings.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

class PreparedJobCache {
 public:
  // Replaces what was kept. `mark` is what mark_of() said of the files before they were read. Nothing is kept
  // when they have changed since, or when a later change would not show: a file behind a symbolic link.
  void keep(const JobFiles& files, const std::string& mark, PreparedJob job);

  // Gives the job when these are its files, wherever they lie by now, and these its settings. Keeps nothing
  // afterwards.
  [[nodiscard]] std::optional<PreparedJob> take(const JobFiles& files,
                                                const std::optional<JobSettings>& settings);
  // Keeps nothing of these files any more.
  void forget(const JobFiles& files);
  void drop() { kept_.reset(); }

  [[nodiscard]] bool empty() const { return !kept_; }

 private:
  struct Kept {
    std::filesystem::path model;  // where it lay then
    std::string mark;
    PreparedJob job;
  };

  std::optional<Kept> kept_;
};

}  // namespace contourd
