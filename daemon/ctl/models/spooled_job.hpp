// A job in the spool, by what its owner calls it. Looks at the disk and changes nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/spool/spool_folders.hpp"

namespace contourd::ctl {

struct SpooledJob {
  JobFiles files;
  SpoolFolder folder{};
  // Where else there is one of that name.
  std::vector<SpoolFolder> others{};
};

// "incoming" and so on.
[[nodiscard]] std::string name_of(SpoolFolder folder);

// By its name, by its file's, or by either as people read it; before others, one that waits or is printed. It
// may lie elsewhere a moment later. Nothing when there is none. Throws UsageError where more than one in a
// folder is meant, and std::system_error when there is no spool, or a folder cannot be read.
[[nodiscard]] std::optional<SpooledJob> find_job(const SpoolFolders& spool, const std::string& name);

}  // namespace contourd::ctl
