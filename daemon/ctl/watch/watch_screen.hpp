// contourctl watch on a whole terminal.
#pragma once

#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/watch/watch_end.hpp"

namespace contourd::ctl {

// The result, to be printed after the terminal was restored.
struct WatchResult {
  WatchEnd::Json ended;               // the ended job; null if unknown
  std::vector<std::string> warnings;  // about this job; may contain unprintable characters
};

// Watches until the end. Throws DaemonError if contourd is gone for a minute, and NoSuchJob as WatchEnd does.
// A signal that ends a program ends the process in the usual way, after the terminal was restored; the key q
// counts as SIGINT.
[[nodiscard]] WatchResult watch_on_screen(const ClientOptions& options, WatchEnd& end);

}  // namespace contourd::ctl
