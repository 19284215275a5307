// contourctl watch on a whole terminal.
#pragma once

#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/watch/watch_end.hpp"

namespace contourd::ctl {

// What it came to, to be told on the terminal as it was before.
struct WatchResult {
  WatchEnd::Json ended;               // null: it is not known
  std::vector<std::string> warnings;  // about that job, not printable
};

// Until the end, and at most until a contourd that is gone has not come back for a minute: throws DaemonError
// then, and NoSuchJob as WatchEnd does. A signal that ends a program, and the key q, end it as that signal
// does.
[[nodiscard]] WatchResult watch_on_screen(const ClientOptions& options, WatchEnd& end);

}  // namespace contourd::ctl
