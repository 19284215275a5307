// Moves a job's files between the spool's folders so that after a power cut at any moment the files are in
// one folder, or their times show which of them belong together. Thread-safe (no shared state); blocks.
#pragma once

#include <cstdint>
#include <filesystem>

#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// Moves the job and syncs the move to the disk. A ticket that belongs to another model too is copied instead.
// Throws std::system_error; then the files are where they were.
void move_files(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to);

// Removes the job's files as far as possible, except a ticket that belongs to another model too.
void remove_files(const SpoolFolders& folders, const JobFiles& job);

// Returns the inode's change time (ctime) in ns, which a move updates too; 0 if the path does not exist.
[[nodiscard]] std::int64_t change_time(const std::filesystem::path& path);

}  // namespace contourd
