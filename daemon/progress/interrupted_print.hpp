// The print that a power cut, a crash or a kill ended in the middle, while its part hangs on the plate. A
// value.
#pragma once

#include <string>

#include "daemon/progress/progress_record.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

struct InterruptedPrint {
  JobFiles files;  // in printing/
  JobProgress progress;
  bool is_latest = true;  // false if the latest copy of the record is damaged
};

// Returns where the print was: "in layer 12 of 200, before or during its light (0.600 mm above the film)".
[[nodiscard]] std::string describe(const JobProgress& progress);

}  // namespace contourd
