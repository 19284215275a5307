// The record in which a daemon stores how its light is turned off. `contourd --light-off` uses it after the
// daemon has crashed, because the configuration may have been changed or broken in the meantime. The record
// is deleted when the light is known to be off. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// Returns the record's path: in the service manager's folder (RUNTIME_DIRECTORY, systemd.exec(5)) if there is
// one, else beside the control socket.
[[nodiscard]] std::filesystem::path light_record_path(const std::filesystem::path& control_socket);

}  // namespace contourd
