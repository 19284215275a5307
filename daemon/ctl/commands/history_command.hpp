// contourctl history and usage: what became of jobs, and what they used. They return the exit code.
#pragma once

#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// What the user typed; empty where it was not.
struct HistoryOptions {
  int last = 20;
  std::string since, outcome, resin, job;
  bool csv = false;
};

// The most that can be asked for.
inline constexpr int kLongestHistory = 10'000;

// Asks page by page, and prints the jobs as lines, as JSON or as CSV. Throws UsageError.
int history(const ClientOptions& client, const HistoryOptions& options);

void print_usage(const nlohmann::ordered_json& usage);

}  // namespace contourd::ctl
