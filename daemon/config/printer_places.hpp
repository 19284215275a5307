// Checks that the folders and files that a printer's file names can exist on this computer. Thread-safe (no
// shared state).
#pragma once

#include <filesystem>

#include "daemon/json/json_document.hpp"

namespace contourd {

// A hint for messages about a read-only file system.
inline constexpr const char* kReadOnlyHint =
    " (under systemd, the unit's ReadWritePaths must name the folder)";

// Returns the folder itself or its nearest ancestor that exists.
[[nodiscard]] std::filesystem::path nearest_existing(std::filesystem::path folder);

// Adds a violation for everything that would keep the daemon from starting on this computer. `folder` is the
// file's folder. Does not check permissions, because the daemon may run as another user.
void check_places(JsonDocument& printer, const std::filesystem::path& folder);

}  // namespace contourd
