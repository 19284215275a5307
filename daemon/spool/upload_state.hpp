// Finds out if a file or plate in incoming/ is complete or is still being written. Blocks as long as the disk
// takes. Thread-safe (no shared state).
#pragma once

#include <string>
#include <vector>

#include "daemon/spool/spool_folders.hpp"

namespace contourd {

struct UploadState {
  std::uintmax_t bytes = 0;  // a plate's files together
  bool being_written = false;
  bool known_to_be_whole = false;    // if false, the file counts as complete after a time without changes
  std::vector<std::string> missing;  // the files that a plate lacks; only plate.json if that is missing
  bool is_there = false;             // if false, there is no job of this name and the other members are unset
  bool is_plate = false;
};

[[nodiscard]] UploadState upload_state(const SpoolFolders& folders, const std::string& file);

// True if a process has the model, its ticket or a plate's file open for writing now, or a plate lacks a
// file.
[[nodiscard]] bool is_unfinished(const JobFiles& job);

}  // namespace contourd
