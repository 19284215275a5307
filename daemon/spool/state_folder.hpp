// The folder of what a daemon must know again after a restart. It is the daemon's own: whoever may put models
// into the spool can neither read nor write there. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// The service manager's (STATE_DIRECTORY, systemd.exec(5)), else beside the spool: SPOOL.state.
[[nodiscard]] std::filesystem::path state_folder_path(const std::filesystem::path& spool);

// Makes the folder if it is not there. Throws std::runtime_error when it cannot be made, or is another
// user's, and takes all rights from others.
void make_state_folder(const std::filesystem::path& folder);

}  // namespace contourd
