// A cache of the next job as its check has prepared it, so that the job is not prepared again when its turn
// comes and nothing has changed. Owns the job's memory. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/placement/job_settings.hpp"
#include "daemon/prepare/print_job.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

class PreparedJobCache {
 public:
  // Replaces the cached job. `mark` is what mark_of() returned before the files were read. Caches nothing if
  // they have changed since, or if a later change would go unnoticed: a file behind a symbolic link.
  void keep(const JobFiles& files, const std::string& mark, PreparedJob job);

  // Returns the cached job if these are its files, in whatever folder they are by now, and its settings;
  // nullopt otherwise. The cache is empty afterwards.
  [[nodiscard]] std::optional<PreparedJob> take(const JobFiles& files,
                                                const std::optional<JobSettings>& settings);
  // Discards the cached job if it has these files.
  void forget(const JobFiles& files);
  void drop() { entry_.reset(); }
  // True if the cached job, if any, was cached from these files.
  [[nodiscard]] bool has(const JobFiles& files) const { return entry_ && entry_->model == files.model; }

  [[nodiscard]] bool empty() const { return !entry_; }

 private:
  struct Entry {
    std::filesystem::path model;  // path when the job was cached
    std::string mark;
    PreparedJob job;
  };

  std::optional<Entry> entry_;
};

}  // namespace contourd
