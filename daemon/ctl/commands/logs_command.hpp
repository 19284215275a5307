// contourctl logs: shows contourd's lines in the journal, by journalctl(1).
#pragma once

#include <optional>
#include <string>

namespace contourd::ctl {

struct LogsOptions {
  std::optional<std::string> job;  // only lines about this job
  std::optional<int> lines;        // at most; nullopt: all lines of a job, or the latest 100
  bool follow = false;
};

// Replaces this process by journalctl, which prints the lines. If there are none, prints the reason and
// returns the exit code. Throws DaemonError if journalctl cannot be started.
int logs(const LogsOptions& options);

}  // namespace contourd::ctl
