// The plate's levelling, step by step with whoever stands at the printer.
#pragma once

#include <filesystem>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct LevelOptions {
  std::filesystem::path config = kDefaultConfig;
};

// Asks by lines on standard input; its end is as good as Ctrl-C. Stores z_axis.switch_height_mm in the
// configuration. Returns the exit code.
int level(const ClientOptions& client, const LevelOptions& options);

}  // namespace contourd::ctl
