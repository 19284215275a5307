// From wired parts to a configuration that works, step by step with whoever stands at the printer.
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
  std::optional<std::filesystem::path> answers;  // a file of them
  std::vector<std::string> set;                  // KEY=VALUE
  bool non_interactive = false;
  bool anew = false;     // what was answered before is forgotten
  bool replace = false;  // an edited configuration, without asking
};

// Writes the configuration, and beside it what was answered and why. Asks by lines on standard input, unless
// it is to ask nothing; what was answered stays when that ends anywhere. Returns the exit code. Throws
// UsageError for what was given and is no answer, or was not and must be; ConfigError for what is wrong with
// the files; OutputError where nothing can be written.
int setup(const ClientOptions& client, const SetupOptions& options);

}  // namespace contourd::ctl
