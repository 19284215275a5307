// The pass over a JSON text before it is read into values: syntax, bounds, duplicate keys.
// Pure functions, thread-safe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/json/config_error.hpp"

namespace contourd {

// Returns the duplicate keys of a text that can be read. Throws ConfigError when it cannot: not UTF-8, not
// JSON, nested deeper than 64, a key or text longer than 1024 bytes or with a NUL in it (system calls would
// see it end there). REQUIRES: no byte order mark.
[[nodiscard]] std::vector<Violation> check_json_syntax(std::string_view text, const std::string& file);

}  // namespace contourd
