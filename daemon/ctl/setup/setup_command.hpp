// contourctl setup: from wired parts to a working configuration, step by step with the user at the printer.
#pragma once

#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Writes the configuration, and next to it the answers and their reasons. Asks questions on standard input
// unless --non-interactive is given; answers are saved one by one, so that an interrupted setup can continue.
// Throws UsageError for an invalid given answer, or a missing answer without a safe default; ConfigError for
// mistakes in the files; OutputError if nothing can be written.
void add_setup(Command& program);

}  // namespace contourd::ctl
