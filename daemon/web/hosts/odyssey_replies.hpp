// Odyssey's answers, as Orion reads them: lengths, times and volumes have a decimal point even if they are
// whole. Thread-safe (no state).
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/web/hosts/host_jobs.hpp"

namespace contourd::web {

// Returns the answer to /status. Without a print, `layer` is null, which means a cancelled print, unless the
// last one was done.
[[nodiscard]] ControlLink::Json odyssey_status(const HostStatus& status);
// Returns the status as a server-sent event.
[[nodiscard]] std::string odyssey_event(const HostStatus& status);

// A page of a list, counted from 0. `size` > 0.
struct OdysseyPage {
  std::size_t index = 0, size = 100;
};
// Returns the answer to /files: the jobs of a page, and the next page's index, or null.
[[nodiscard]] ControlLink::Json odyssey_files(const std::vector<HostJob>& jobs, const OdysseyPage& page);
// Returns the answer to /file/metadata, and the `file_data` in it.
[[nodiscard]] ControlLink::Json odyssey_metadata(const HostJob& job);
[[nodiscard]] ControlLink::Json odyssey_file_data(const HostJob& job);
// Returns the answer to /config: the printer's name, and its greatest height from contourd's `methods`, 0.0
// if they do not tell it.
[[nodiscard]] ControlLink::Json odyssey_config(const std::string& printer, const ControlLink::Json& methods);

}  // namespace contourd::web
