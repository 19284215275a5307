// Brings to printing/ by copy what may be read but not moved, such as a folder that another made for himself
// alone, and takes such a copy back. A copy under way lies under a name that is no job's: in printing/, a job
// is whole. One call at a time, from any thread, but for stop(), which may be called beside it; blocks.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"
#include "daemon/spool/state_records.hpp"

namespace contourd {

// What came of a copy.
struct JobCopy {
  std::optional<JobFiles> job;  // in printing/
  std::string unreadable{};     // else a sentence, when that is why: it can be refused
  std::string trouble{};        // else why it is to be tried again
};

class PrintingCopies {
 public:
  // All must outlive the copies.
  PrintingCopies(const SpoolFolders& folders, const StateRecords& records, CopiedOriginals& originals);

  // Copies incoming/`file`, under a name that no job has. Where the original could be removed it is; else it
  // is among the originals, and the job names it.
  [[nodiscard]] JobCopy copy(const std::string& file);
  // Removes a copy whose original is to be taken again. Throws std::system_error.
  void take_back(const JobFiles& copy);
  // Copies to incoming/ what cannot be moved there either. Throws std::runtime_error.
  void give_back(const JobFiles& from, const JobFiles& to);

  // What is being copied, and would be, is given up soon.
  void stop() { stopped_ = true; }
  // What a daemon that was killed was copying.
  void remove_leftovers() const;

 private:
  [[nodiscard]] JobFiles copy_whole(const std::string& file);

  const SpoolFolders& folders_;
  const StateRecords& records_;
  CopiedOriginals& originals_;
  std::filesystem::path under_way_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace contourd
