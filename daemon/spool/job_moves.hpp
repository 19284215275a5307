// Moves a job's files between the spool's folders so that after a power cut at any moment the files are in
// one folder, or their times show which of them belong together. Thread-safe (no shared state); blocks.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// Moves the job and syncs the move to the disk. A ticket that belongs to another model too is copied instead.
// Throws std::system_error; then the files are where they were.
void move_files(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to);

// Moves an ended job to done/ or failed/ with move_files(), or copies it if the folder is on another file
// system. Throws std::system_error; then the files are where they were, and a copy may be there, too, which
// the next call replaces.
void file_away(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to);

// True if this error of move_files() means that the job can only be copied.
[[nodiscard]] bool is_immovable(const std::error_code& code);

// A model that was moved out of incoming/.
struct MovedModel {
  std::string file;    // its name in incoming/
  SpoolFolder folder;  // where it is now
  std::string model;   // its name there
  std::string mark;    // mark_of() before the move
};
// Moves the model's ticket after it, if a power cut separated these two moves: the model has no ticket, and
// the ticket in incoming/ is older than the model's move. Does nothing otherwise, or if it fails.
void bring_ticket(const SpoolFolders& folders, const MovedModel& moved);

// Removes the job's files as far as possible, except a ticket that belongs to another model too.
void remove_files(const SpoolFolders& folders, const JobFiles& job);

// Returns the inode's change time (ctime) in ns, which a move updates too; 0 if the path does not exist.
[[nodiscard]] std::int64_t change_time(const std::filesystem::path& path);

// Returns the models and plates in printing/. Moves a ticket there if its model was moved and the ticket was
// not yet. Moves all other files to failed/, or to incoming/ or done/ if they are tickets of models there, as
// far as possible. Throws std::filesystem::filesystem_error if the folder cannot be read.
[[nodiscard]] std::vector<JobFiles> jobs_left_in_printing(const SpoolFolders& folders);

// Thrown if one of the job's files cannot be read or is not a file. what() is a sentence.
class JobUnreadable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Copies the job and syncs the copy to the disk; blocks. The folder of `to` exists, its files do not. Throws
// JobUnreadable, ConfigError if a plate's ticket cannot be used, and std::system_error: with
// no_space_on_device if the job is larger than `most_bytes`, with operation_canceled if `stop` is set
// meanwhile. A partial copy remains after an exception.
void copy_job(const JobFiles& from, const JobFiles& to, std::uintmax_t most_bytes,
              const std::atomic<bool>& stop);

// Copies a ticket and syncs it to the disk; blocks. Throws JobUnreadable, also if the ticket is too large,
// and std::system_error.
void copy_ticket(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace contourd
