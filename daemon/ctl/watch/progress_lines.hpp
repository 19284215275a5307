// Prints a job's progress as text: a line for each tenth of the print and for other changes. Each warning is
// printed once, in its own line.
#pragma once

#include <set>
#include <string>

#include "daemon/client/daemon_connection.hpp"

namespace contourd::ctl {

class ProgressLines {
 public:
  using Json = DaemonConnection::Json;

  // Prints lines that are due. `job`: the awaited job, which may not be printed yet; empty: any job.
  void show(const Json& status, const std::string& job, bool is_under_way);

 private:
  void show_job(const Json& status);
  void show_warnings(const Json& job);
  // Prints the text if `step` has changed.
  void print(const std::string& text, const std::string& step);

  std::string last_step_;
  std::set<std::string> warned_;  // printed warnings: job name, line break, warning
};

}  // namespace contourd::ctl
