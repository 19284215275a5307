// Whether the folders and files that a printer's file names can be there on this computer. Thread-safe (no
// shared state).
#pragma once

#include <filesystem>

#include "daemon/json/json_document.hpp"

namespace contourd {

// What may be the matter when a file system is read-only.
inline constexpr const char* kReadOnlyHint =
    " (under systemd, the unit's ReadWritePaths must name the folder)";

// The first of the folder and those above it that is there.
[[nodiscard]] std::filesystem::path nearest_existing(std::filesystem::path folder);

// Adds what keeps a daemon here from starting. `folder` is the file's. Not permissions: it may run as another
// user than who asks.
void check_places(JsonDocument& printer, const std::filesystem::path& folder);

}  // namespace contourd
