// The live states of the printer's inputs, for whoever wires them.
#pragma once

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Prints all inputs, then each that changes: in place on a terminal, else a line each. Until it is
// interrupted or the daemon refuses, as when a print begins; only once if so wanted. Returns the exit code.
int show_switches(const ClientOptions& options, bool once);

}  // namespace contourd::ctl
