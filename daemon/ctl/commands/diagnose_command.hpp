// contourctl diagnose: collects the facts for a bug report in one small archive without secrets.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct DiagnoseOptions {
  std::optional<std::filesystem::path> output;  // nullopt: named by the time, in the working folder
  std::filesystem::path config = kDefaultConfig;
  std::optional<std::string> job;  // nullopt: the latest
};

// Writes the archive, with or without a running daemon, and lists its files. Returns the exit code; throws
// OutputError if the archive cannot be written or a file of that name exists.
int diagnose(const ClientOptions& client, const DiagnoseOptions& options);

}  // namespace contourd::ctl
