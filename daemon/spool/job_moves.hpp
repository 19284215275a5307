// Moves a job's files between the spool's folders so that, whenever the power is cut, they are in one place
// or told apart by their times. Thread-safe (no shared state); blocks.
#pragma once

#include <cstdint>
#include <filesystem>

#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// A ticket that is meant for another model too stays where it is, and is copied. On the disk when the call
// returns. Throws std::system_error; then the files are where they were.
void move_files(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to);

// What the job consists of, as far as that is possible; but no ticket that is meant for another model too.
void remove_files(const SpoolFolders& folders, const JobFiles& job);

// When what has this name was changed last, or moved here; in nanoseconds; 0 when it is not there.
[[nodiscard]] std::int64_t change_time(const std::filesystem::path& path);

}  // namespace contourd
