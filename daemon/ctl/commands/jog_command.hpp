// The plate moved by keys, in a terminal.
#pragma once

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct JogOptions {
  double light_s = 5;
  bool plate_is_clear = false, in_resin = false;
};

// Until q, Ctrl-C, or the end of the terminal, which ends what a key has begun. Returns the exit code. Throws
// UsageError where there is no terminal.
int jog(const ClientOptions& client, const JogOptions& options);

}  // namespace contourd::ctl
