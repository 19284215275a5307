// contourctl watch. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Shows the print under way until it ends, or until the job of that name has ended (which may be before the
// call); one that is nowhere for some seconds is told.
int watch(const ClientOptions& options, const std::optional<std::string>& job);

}  // namespace contourd::ctl
