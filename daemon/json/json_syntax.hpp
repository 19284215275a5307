// Checks a JSON text before it is parsed into values: syntax, limits, duplicate keys. Pure functions,
// thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/json/config_error.hpp"

namespace contourd {

// Returns a violation for each duplicate key. Throws ConfigError if the text is not UTF-8, begins with a byte
// order mark (the caller removes the only one that a file may have), is not JSON, is nested deeper than 64,
// or has a key or text that is longer than 1024 bytes or contains a NUL (which would end it in system calls).
[[nodiscard]] std::vector<Violation> check_json_syntax(std::string_view text, const std::string& file);

}  // namespace contourd
