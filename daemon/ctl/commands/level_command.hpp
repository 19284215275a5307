// contourctl level: levels the plate, step by step, together with the user at the printer.
#pragma once

#include <filesystem>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct LevelOptions {
  std::filesystem::path config = kDefaultConfig;
};

// Asks questions on standard input and stores z_axis.switch_height_mm in the configuration. The end of
// standard input quits, as q does. Returns the exit code.
int level(const ClientOptions& client, const LevelOptions& options);

}  // namespace contourd::ctl
