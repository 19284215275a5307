// Files a job that has no report: moves it out of printing/ and writes a reason beside it. Failures are
// logged. Event loop's thread only; blocks, so the light must be off.
#pragma once

#include <string>

#include "daemon/spool/spool.hpp"
#include "daemon/system/log.hpp"

namespace contourd {

// Moves the job; an empty reason writes no file. Throws std::system_error if the job stays in printing/.
void move_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason);
// Does the same as move_job(), but logs an error if the job stays in printing/.
void file_job(const Spool& spool, const Log& log, const JobFiles& files, Spool::Folder to,
              const std::string& reason);

}  // namespace contourd
