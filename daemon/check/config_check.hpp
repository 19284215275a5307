// What an owner is told of a printer's configuration before contourd takes it. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// Prints a line for all that is allowed but implausible, and that it is good. Throws ConfigError when it is
// not.
void check_config(const std::filesystem::path& file);

}  // namespace contourd
