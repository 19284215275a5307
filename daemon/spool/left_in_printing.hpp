// Finds the jobs that a daemon left in printing/ because it ended during a print. Thread-safe (no shared
// state); blocks.
#pragma once

#include <vector>

#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// Returns the models and plates in printing/. Moves a ticket there if its model was moved and the ticket was
// not yet. Moves all other files to failed/, or to incoming/ or done/ if they are tickets of models there, as
// far as possible. Throws std::filesystem::filesystem_error if the folder cannot be read.
[[nodiscard]] std::vector<JobFiles> jobs_left_in_printing(const SpoolFolders& folders);

}  // namespace contourd
