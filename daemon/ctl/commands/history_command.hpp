// contourctl history and usage: the outcomes of jobs, and the consumption of resin and parts.
#pragma once

#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Arguments as the user typed them; empty if not given.
struct HistoryOptions {
  int last = 20;
  std::string since, outcome, resin, job;
  bool csv = false;
};

// Upper limit of HistoryOptions::last.
inline constexpr int kLongestHistory = 10'000;

// Asks contourd page by page, and prints the jobs as lines, as JSON or as CSV. Returns the exit code. Throws
// UsageError.
int history(const ClientOptions& client, const HistoryOptions& options);

void print_usage(const nlohmann::ordered_json& usage);

}  // namespace contourd::ctl
