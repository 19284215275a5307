// The record that a daemon leaves of what turns its light off: `contourd --light-off` goes by it when the
// daemon has died, as the configuration may have been changed since, or broken. It goes when the light is
// known to be off. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// In the service manager's folder (RUNTIME_DIRECTORY, systemd.exec(5)), else beside the control socket.
[[nodiscard]] std::filesystem::path light_record_path(const std::filesystem::path& control_socket);

}  // namespace contourd
