// contourctl jog: moves the plate by keys, in a terminal.
#pragma once

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct JogOptions {
  double light_s = 5;
  bool plate_is_clear = false, in_resin = false;
};

// Runs until q, Ctrl-C, or the end of the terminal; each of these also stops the current operation. Returns
// the exit code. Throws UsageError if standard input or output is not a terminal.
int jog(const ClientOptions& client, const JogOptions& options);

}  // namespace contourd::ctl
