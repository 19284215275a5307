// contourctl mask: the picture on the printer's display.
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Writes the picture as a PNG file ("-": standard output), or draws it if `output` is nullopt. If nothing is
// shown, writes nothing. Returns the exit code. Throws DaemonError, OutputError and UsageError.
int mask(const ClientOptions& client, const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
