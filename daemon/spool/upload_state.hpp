// Whether what somebody puts into incoming/ is whole, or is still being written. Blocks as long as the disk
// takes. Thread-safe (no shared state).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/spool/spool_folders.hpp"

namespace contourd {

struct UploadState {
  std::uintmax_t bytes = 0;  // a plate's files together
  bool being_written = false;
  bool known_to_be_whole = false;    // else it counts as whole when it stays as it is
  std::vector<std::string> missing;  // of a plate: what it lacks, its plate.json alone if it lacks that
  bool is_there = false;             // else there is nothing to be taken, and the rest says nothing
  bool is_plate = false;
};

[[nodiscard]] UploadState upload_state(const SpoolFolders& folders, const std::string& file);

// Whether at this moment somebody has the model, its ticket or a plate's file open for writing, or a plate
// lacks a file.
[[nodiscard]] bool is_unfinished(const JobFiles& job);

}  // namespace contourd
