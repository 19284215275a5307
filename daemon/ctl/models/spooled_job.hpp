// Finds a job in the spool by a name that a user types. Only reads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/spool/spool_folders.hpp"

namespace contourd::ctl {

struct SpooledJob {
  JobFiles files;
  SpoolFolder folder{};
  // Other folders with a job of this name.
  std::vector<SpoolFolder> others{};
};

// Returns "incoming" and so on.
[[nodiscard]] std::string name_of(SpoolFolder folder);

// Finds a job by its name, its file's name, or the printable form of either; a waiting or printing job comes
// before others. The job may be moved at any time. Returns nullopt if there is none. Throws UsageError if the
// name fits several jobs of a folder, and std::system_error if there is no spool or a folder cannot be read.
[[nodiscard]] std::optional<SpooledJob> find_job(const SpoolFolders& spool, const std::string& name);

}  // namespace contourd::ctl
