// contourctl watch: follows a print. Problems with the daemon are thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Shows the current print until it ends, or until the job with this name has ended, possibly before the call.
// Reports a job that contourd does not know for some seconds. Returns the exit code, or nullopt if the user
// left the view by the key q.
std::optional<int> watch(const ClientOptions& options, const std::optional<std::string>& job);

void add_watch(Command& program);

}  // namespace contourd::ctl
