// contourctl mask: what the display shows. Prints its result and returns the exit code; what is wrong with
// the daemon comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// As a PNG file, "-" for standard output; without it, it is drawn. Nothing is written when nothing is shown.
int mask(const ClientOptions& client, const std::optional<std::filesystem::path>& output);

}  // namespace contourd::ctl
