// The folder for the state that survives a restart of the daemon. It is private to the daemon: users who may
// put models into the spool can neither read nor write it. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// Returns the service manager's folder (STATE_DIRECTORY, systemd.exec(5)), or SPOOL.state beside the spool.
[[nodiscard]] std::filesystem::path state_folder_path(const std::filesystem::path& spool);

// Makes the folder if it does not exist, and removes all permissions of other users. Throws
// std::runtime_error if the folder cannot be made or belongs to another user.
void make_state_folder(const std::filesystem::path& folder);

}  // namespace contourd
