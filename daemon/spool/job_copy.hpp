// Copies a job that can be read but not moved. Thread-safe (no shared state).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <stdexcept>

#include "daemon/spool/job_files.hpp"

namespace contourd {

// One of the job's files cannot be read, or is none. what() is a sentence.
class JobUnreadable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Has the copy on the disk before it returns; blocks. `to` is new, but for the folder that it is in. Throws
// JobUnreadable, ConfigError when a plate's ticket cannot be used, and std::system_error, with
// std::errc::operation_canceled when `stop` is set meanwhile; what was copied until then lies there.
void copy_job(const JobFiles& from, const JobFiles& to, std::uintmax_t most_bytes,
              const std::atomic<bool>& stop);

// The same for a ticket, which is small or refused as too large (JobUnreadable).
void copy_ticket(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace contourd
