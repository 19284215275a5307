// Files a job that has no report: moves it out of printing/, a reason beside it. What goes wrong is in the
// log. Event loop's thread only; blocks, so it is for the dark.
#pragma once

#include <string>

#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

// An empty reason leaves no file. Throws std::system_error when the job stays in printing/.
void move_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason);
// The same, but that it stays is told.
void file_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason);

}  // namespace contourd
