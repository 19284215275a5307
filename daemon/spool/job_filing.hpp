// Files a job that has no report: moves it out of printing/ and writes a reason beside it. Any thread; blocks
// until the disk has it.
#pragma once

#include <string>
#include <vector>

#include "daemon/spool/spool.hpp"

namespace contourd {

// Moves the job; an empty reason writes no file. Returns a sentence for each thing that is missing. Throws
// std::system_error if the job stays in printing/.
[[nodiscard]] std::vector<std::string> move_job(Spool& spool, const JobFiles& files, Spool::Folder to,
                                                const std::string& reason);

}  // namespace contourd
