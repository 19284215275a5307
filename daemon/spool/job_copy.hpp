// Copies a job that can be read but not moved. Thread-safe (no shared state).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <stdexcept>

#include "daemon/spool/job_files.hpp"

namespace contourd {

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
