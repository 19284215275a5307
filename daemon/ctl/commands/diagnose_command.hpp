// One archive with what somebody who is to help wants to know: nothing in it is secret, and it is small.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/client/control_defaults.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct DiagnoseOptions {
  std::optional<std::filesystem::path> output;  // nothing: named by the time, in the working folder
  std::filesystem::path config = kDefaultConfig;
  std::optional<std::string> job;  // nothing: the latest
};

// Works with or without a daemon. Says what is in it. Returns the exit code; throws OutputError when the
// archive cannot be written, or something has its name already.
int diagnose(const ClientOptions& client, const DiagnoseOptions& options);

}  // namespace contourd::ctl
