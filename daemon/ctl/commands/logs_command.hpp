// contourd's lines in the journal, by journalctl(1).
#pragma once

#include <optional>
#include <string>

namespace contourd::ctl {

struct LogsOptions {
  std::optional<std::string> job;  // its lines alone
  std::optional<int> lines;        // the latest; without it all of a job's
  bool follow = false;
};

// Ends as journalctl, which prints them; or returns the exit code after a word on why there is nothing.
int logs(const LogsOptions& options);

}  // namespace contourd::ctl
