// contourctl setup: from wired parts to a working configuration, step by step with the user at the printer.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct SetupOptions {
  std::filesystem::path config = kDefaultConfig;
  std::optional<std::filesystem::path> answers;  // JSON file with answers
  std::vector<std::string> set;                  // KEY=VALUE
  bool non_interactive = false;
  bool restart = false;  // discard the answers of earlier calls
  bool replace = false;  // replace an edited configuration without asking
};

// Writes the configuration, and next to it the answers and their reasons. Asks questions on standard input
// unless `non_interactive` is set; answers are saved one by one, so that an interrupted setup can continue.
// Returns the exit code. Throws UsageError for an invalid given answer, or a missing answer without a safe
// default; ConfigError for mistakes in the files; OutputError if nothing can be written.
int setup(const ClientOptions& client, const SetupOptions& options);

}  // namespace contourd::ctl
