// Copies jobs to printing/ that can be read but not moved, such as a folder that only its owner may write,
// and removes such copies again. An unfinished copy has a name that no job can have, so that every job in
// printing/ is complete. One call at a time, from any thread, except stop(), which may be called at any time;
// blocks.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_ends.hpp"
#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// The result of a copy: a job, or one of two reasons.
struct JobCopy {
  std::optional<JobFiles> job;  // the copy in printing/
  std::string unreadable{};     // why the job cannot be read and can be refused, a sentence
  std::string trouble{};        // why the copy failed and is to be retried
};

class PrintingCopies {
 public:
  // The arguments must outlive the object.
  PrintingCopies(const SpoolFolders& folders, JobEndRecord& ends, CopiedOriginals& originals);

  // Copies incoming/`file` to a name that no job has. Then removes the original; if that is impossible, adds
  // it to the originals and sets the job's `original`.
  [[nodiscard]] JobCopy copy(const std::string& file);
  // Removes a copy from printing/ so that its original can be taken again. Throws std::system_error.
  void take_back(const JobFiles& copy);
  // Copies a job to incoming/ that cannot be moved there, and removes it from printing/. Throws
  // std::runtime_error.
  void give_back(const JobFiles& from, const JobFiles& to);

  // Makes the current copy and all later ones fail soon.
  void stop() { stopped_ = true; }
  // Removes the unfinished copy of a daemon that was killed.
  void remove_leftovers() const;

 private:
  [[nodiscard]] JobFiles copy_whole(const std::string& file);

  const SpoolFolders& folders_;
  JobEndRecord& ends_;
  CopiedOriginals& originals_;
  std::filesystem::path under_way_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace contourd
