// Values of options that completion in a shell offers. Each function returns an empty list if contourd does
// not answer.
#pragma once

#include <string>
#include <vector>

namespace contourd::ctl {

[[nodiscard]] std::vector<std::string> waiting_jobs();
// Returns the jobs that wait to be accepted.
[[nodiscard]] std::vector<std::string> unaccepted_jobs();
// Returns the current job and the waiting jobs.
[[nodiscard]] std::vector<std::string> current_jobs();
// Returns the current job, the waiting jobs and the latest ended jobs.
[[nodiscard]] std::vector<std::string> all_jobs();
// Returns the names of the installed resin profiles.
[[nodiscard]] std::vector<std::string> resins();

}  // namespace contourd::ctl
