// contourctl config: checks and shows a printer's configuration. Each command prints its result, reports
// mistakes on standard error, and returns the exit code.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/client/control_defaults.hpp"

namespace contourd::ctl {

struct ConfigOptions {
  std::filesystem::path file = kDefaultConfig;
  std::string format = "printer";  // for config_schema(): one of config_formats()
};

// Checks the file as contourd --check-config does.
int config_check(const ConfigOptions& options);
// Prints the file with all defaults, as JSON.
int config_show(const ConfigOptions& options);
// Prints a line for each value that differs from its default or has no default.
int config_diff(const ConfigOptions& options);
// Prints the JSON schema of a format. REQUIRES: the format is one of config_formats().
int config_schema(const ConfigOptions& options);

// Returns the names of the file formats that have a schema.
[[nodiscard]] std::vector<std::string> config_formats();

}  // namespace contourd::ctl
