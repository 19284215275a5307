// What a daemon that did not end its print left in printing/. Thread-safe (no shared state); blocks.
#pragma once

#include <vector>

#include "daemon/spool/job_files.hpp"
#include "daemon/spool/spool_folders.hpp"

namespace contourd {

// Models and plates. A ticket that was to follow its model is brought. What else lies there goes to failed/,
// or back to incoming/ or on to done/ if it is the ticket of a model there, as far as that is possible.
// Throws std::filesystem::filesystem_error when the folder cannot be read.
[[nodiscard]] std::vector<JobFiles> jobs_left_in_printing(const SpoolFolders& folders);

}  // namespace contourd
