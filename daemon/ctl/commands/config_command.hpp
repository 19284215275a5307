// A printer's configuration as its owner wrote it, and what contourd makes of it. Prints, and returns the
// exit code; throws ConfigError when it is not good.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/client/control_defaults.hpp"

namespace contourd::ctl {

struct ConfigOptions {
  std::filesystem::path file = kDefaultConfig;
  std::string format = "printer";  // whose schema
};

// As contourd --check-config.
int config_check(const ConfigOptions& options);
// With all defaults, as JSON.
int config_show(const ConfigOptions& options);
// A line for each value that is not the default, or for which there is none.
int config_diff(const ConfigOptions& options);
int config_schema(const ConfigOptions& options);

// Those that have a schema.
[[nodiscard]] std::vector<std::string> config_formats();

}  // namespace contourd::ctl
