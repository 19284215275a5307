// Checks a printer's configuration before contourd uses it. Thread-safe (no shared state).
#pragma once

#include <filesystem>

namespace contourd {

// Checks the printer's file: prints a line for each value that is allowed but implausible, then a line that
// the file is good. Throws ConfigError if the file is wrong.
void check_config(const std::filesystem::path& file);

}  // namespace contourd
