#include "daemon/spool/job_moves.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <system_error>

#include "daemon/spool/copied_originals.hpp"
#include "daemon/spool/job_copy.hpp"
#include "daemon/system/durable_file.hpp"

namespace contourd {
namespace {

namespace fs = std::filesystem;

void move_ticket(const JobFiles& from, const JobFiles& to, bool shared) {
  if (shared) {
    try {
      return copy_ticket(*from.ticket, *to.ticket);
    } catch (const JobUnreadable&) {
      // The ticket is moved instead; its reader then reports what is wrong with it.
    }
  }
  std::error_code code;
  fs::rename(*from.ticket, *to.ticket, code);
  if (code && code != std::errc::no_such_file_or_directory)
    throw std::system_error(code,
                            fmt::format("cannot move {} to {}", from.ticket->string(), to.ticket->string()));
}

}  // namespace

void move_files(const SpoolFolders& folders, const JobFiles& from, const JobFiles& to) {
  const bool shared = folders.shares_ticket(from);
  // The model moves first, because the model's folder is the job's folder. A power cut between the two moves
  // then leaves an interrupted job; in the other order the job would be printed without its ticket.
  fs::rename(from.model, to.model);
  try {
    if (from.ticket) move_ticket(from, to, shared);
  } catch (const std::system_error&) {
    std::error_code ignored;
    fs::rename(to.model, from.model, ignored);
    throw;
  }
  sync_folder(to.model.parent_path());
  sync_folder(from.model.parent_path());
}

void remove_files(const SpoolFolders& folders, const JobFiles& job) {
  JobFiles own = job;
  if (folders.shares_ticket(job)) own.ticket.reset();
  std::error_code ignored;
  for (const fs::path& part : parts_of(own))
    fs::remove(part, ignored);
  if (own.plate) fs::remove(own.model, ignored);
}

std::int64_t change_time(const fs::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return 0;
  return status.st_ctim.tv_sec * std::int64_t{1'000'000'000} + status.st_ctim.tv_nsec;
}

}  // namespace contourd
