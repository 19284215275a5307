// contourctl switches: the live states of the printer's inputs, for wiring.
#pragma once

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Prints all inputs, then each change: in place on a terminal, otherwise one line per change. Runs until it
// is interrupted or the daemon refuses, for example because a print begins; with `once`, prints the states
// once. Returns the exit code.
int show_switches(const ClientOptions& options, bool once);

}  // namespace contourd::ctl
