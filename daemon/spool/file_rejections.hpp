// Moves jobs that are refused or removed before their turn from incoming/ to failed/, with the reason beside
// them. The end is recorded first, so that the next process can complete a move that a power cut or a kill
// separated. One call at a time, from any thread; blocks.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_ends.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// The results of FileRejections::file().
enum class Rejection : std::uint8_t {
  Filed,
  LeftThere,   // the reason is filed, but the files cannot be moved; a user may delete them
  Unfinished,  // a process writes the job again, so it stays in incoming/
  Impossible,  // the job stays in incoming/; `trouble` says why
};

class FileRejections {
 public:
  struct Result {
    Rejection rejection = Rejection::Impossible;
    std::string trouble{};  // why the job stays in incoming/, or why its reason file is missing
    std::string job{};      // its name in failed/
  };

  // The arguments must outlive the object.
  FileRejections(const SpoolFolders& folders, JobEndRecord& ends, CopiedOriginals& originals)
      : folders_(folders), ends_(ends), originals_(originals) {}

  // Moves incoming/`file` to a name that no job has. `end` has the key, the outcome and the reason.
  [[nodiscard]] Result file(const std::string& file, JobEnd end);
  // Completes the rejections that the last process left unfinished, as far as possible.
  void finish();

 private:
  void move(const std::string& file, JobEnd& end, Result& result);
  // Moves the files, or notes that they stay in incoming/ for good. Throws std::system_error.
  [[nodiscard]] Rejection move_files_of(const JobFiles& from, const JobFiles& to, const JobEnd& end);
  // Returns why the reason cannot be written; empty on success.
  [[nodiscard]] std::string write_reason(const JobEnd& end) const;

  const SpoolFolders& folders_;
  JobEndRecord& ends_;
  CopiedOriginals& originals_;
};

}  // namespace contourd
